#include "tagcal/estimate/halves.hpp"

#include <array>
#include <cmath>

#include "tagcal/estimate/projection_uncertainty.hpp"
#include "tagcal/estimate/uncertainty.hpp"

namespace tagcal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kFewestViews = 6;
constexpr double kLargestRatio = 2;

// Whether chi-square with k degrees of freedom exceeds its 0.999 quantile (Wilson & Hilferty 1931).
bool improbable(double chi_square, double k) {
  constexpr double kNormalQuantile = 3.09;
  const double quantile = 1 - 2 / (9 * k) + kNormalQuantile * std::sqrt(2 / (9 * k));
  return chi_square > k * quantile * quantile * quantile;
}

}  // namespace

std::optional<HalvesCheck> compare_halves(const Bundle& solved, double sigma,
                                          std::span<const Eigen::Vector2d> samples,
                                          double distance_m) {
  const Eigen::Index k = solved.model->num_free();
  if (solved.views.size() < kFewestViews || k == 0) return std::nullopt;
  const Lens lens = solved.lens();
  std::array<MatrixXd, 2> information = {MatrixXd::Zero(k, k), MatrixXd::Zero(k, k)};
  std::array<VectorXd, 2> gradient = {VectorXd::Zero(k), VectorXd::Zero(k)};
  for (std::size_t i = 0; i < solved.views.size(); ++i) {
    const auto view =
        information_of(solved.views[i], lens, solved.model->free(), solved.camera_from_target[i]);
    if (!view) return std::nullopt;
    information[i % 2] += view->information;
    gradient[i % 2] += view->gradient;
  }
  const auto first = exact_inverse(information[0]), second = exact_inverse(information[1]);
  if (!first || !second) return std::nullopt;
  const VectorXd difference = *second * gradient[1] - *first * gradient[0];
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
  check.disagree = check.ratio > kLargestRatio && inverse &&
                   improbable(difference.dot(*inverse * difference), static_cast<double>(k));
  return check;
}

}  // namespace tagcal
