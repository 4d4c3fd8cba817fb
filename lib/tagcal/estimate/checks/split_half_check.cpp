#include "tagcal/estimate/checks/split_half_check.hpp"

#include <cmath>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

std::optional<HalvesCheck> split_half_check(const Bundle& solved,
                                            const BundleInformation& information, double sigma,
                                            std::span<const Eigen::Vector2d> samples,
                                            double distance_m) {
  const Eigen::Index k = solved.model->num_free();
  if (solved.views.size() < policy::kSplitHalfFewestViews || k == 0) return std::nullopt;
  const Lens lens = solved.lens();
  const auto first = exact_inverse(information.halves[0].topLeftCorner(k, k)),
             second = exact_inverse(information.halves[1].topLeftCorner(k, k));
  if (!first || !second) return std::nullopt;
  const VectorXd difference =
      *second * information.gradients[1].head(k) - *first * information.gradients[0].head(k);
  const MatrixXd covariance = sigma * sigma * (*first + *second);
  const MatrixXd projection =
      aligned_jacobian({solved.model, lens, covariance}, samples, distance_m);
  if (projection.rows() == 0) return std::nullopt;
  HalvesCheck check;
  const auto rows = static_cast<double>(projection.rows());
  check.difference_px = std::sqrt((projection * difference).squaredNorm() / rows);
  check.predicted_px = std::sqrt((projection * covariance).cwiseProduct(projection).sum() / rows);
  check.ratio = check.predicted_px > 0 ? check.difference_px / check.predicted_px : 0;
  const auto inverse = exact_inverse(covariance);
  check.disagree = check.ratio > policy::kHalvesDisagree && inverse &&
                   difference.dot(*inverse * difference) >
                       chi_square_quantile(static_cast<double>(k), policy::kQuantile1e3);
  return check;
}

}  // namespace tagcal::internal
