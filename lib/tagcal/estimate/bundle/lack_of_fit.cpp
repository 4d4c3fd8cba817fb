#include "tagcal/estimate/bundle/lack_of_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kColumns = 12, kRows = 8;  // of the grid over the image
constexpr std::size_t kRings = 16;

// Residuals by groups of corners. A radial part stands in x; y is 0 then.
class GroupedResiduals {
 public:
  explicit GroupedResiduals(std::size_t num_groups) : groups_(num_groups) {}

  void add(std::size_t group, const Vector2d& whitened, const Vector2d& px) {
    Group& sums = groups_[group];
    ++sums.count;
    sums.whitened += whitened;
    sums.px += px;
    total_ += whitened.squaredNorm();
  }

  // Chi-square test of the groups' means against the noise within the groups. `coordinates`: those
  // of each mean (2, or 1 for radial parts); `freedom`: of the sum of all squares.
  ResidualBias bias(int coordinates, double freedom, double least_sigma) const {
    double between = 0, square_px = 0, k = 0;
    int corners = 0;
    for (const Group& group : groups_) {
      if (group.count == 0) continue;
      k += coordinates;
      corners += group.count;
      between += group.whitened.squaredNorm() / group.count;
      square_px += group.px.squaredNorm() / group.count;
    }
    ResidualBias bias;
    const double rest = freedom - k;
    if (k == 0 || rest < k) return bias;  // too few to know the noise within the groups
    const double variance = std::max((total_ - between) / rest, least_sigma * least_sigma);
    const double chi_square = between / variance;
    // The second factor is the uncertainty of the variance, which has `rest` degrees of freedom.
    const double bound = chi_square_quantile(k, policy::kSignificant) *
                         (1 + policy::kSignificant * std::sqrt(2 / rest));
    if (chi_square > k) bias.rms_px = std::sqrt((1 - k / chi_square) * square_px / corners);
    bias.disagree = chi_square > bound && bias.rms_px > policy::kLeastSigmaPx;
    return bias;
  }

 private:
  struct Group {
    int count = 0;
    Vector2d whitened = Vector2d::Zero(), px = Vector2d::Zero();
  };
  std::vector<Group> groups_;
  double total_ = 0;
};

std::size_t cell_of(const Vector2d& pixel, const ImageSize& size) {
  const Vector2d from_border =
      pixel + Vector2d::Constant(0.5);  // numeric: the image begins at -0.5
  const int column = static_cast<int>(kColumns * from_border.x() / size.width);
  const int row = static_cast<int>(kRows * from_border.y() / size.height);
  return static_cast<std::size_t>(kColumns * std::clamp(row, 0, kRows - 1) +
                                  std::clamp(column, 0, kColumns - 1));
}

// Radii that separate rings of about equal numbers of corners.
std::vector<double> ring_bounds(const Bundle& bundle, const Vector2d& centre) {
  constexpr std::size_t kEnoughCorners = 2000;
  const std::size_t stride = 1 + static_cast<std::size_t>(num_corners(bundle)) / kEnoughCorners;
  std::vector<double> radii, bounds;
  std::size_t count = 0;
  for (const ViewProblem& view : bundle.views)
    for (const Correspondence& c : view.correspondences)
      if (count++ % stride == 0) radii.push_back((c.pixel - centre).norm());
  std::sort(radii.begin(), radii.end());
  for (std::size_t ring = 1; ring < kRings; ++ring)
    bounds.push_back(radii[ring * radii.size() / kRings]);
  return bounds;
}

}  // namespace

ResidualBias residual_bias(const Bundle& solved, double least_sigma) {
  const Lens lens = solved.lens();
  const Vector2d centre(parameters(lens)[kCx], parameters(lens)[kCy]);
  const std::vector<double> bounds = ring_bounds(solved, centre);
  GroupedResiduals cells(kColumns * kRows), rings(kRings);
  ViewProblem buffer;
  for (std::size_t v = 0; v < solved.views.size(); ++v) {
    const ViewProblem& view = solved.corrected(v, buffer);
    const auto residuals = residuals_px(view.correspondences, lens, solved.camera_from_target[v]);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const Vector2d &pixel = view.correspondences[i].pixel, &px = residuals[i];
      const Vector2d whitened = view.whitening.empty() ? px : Vector2d(view.whitening[i] * px);
      const double radius = (pixel - centre).norm();
      const auto ring = std::upper_bound(bounds.begin(), bounds.end(), radius) - bounds.begin();
      const Vector2d outward = (pixel - centre).normalized();
      cells.add(cell_of(pixel, solved.image_size), whitened, px);
      rings.add(static_cast<std::size_t>(ring), {whitened.dot(outward), 0}, {px.dot(outward), 0});
    }
  }
  const double freedom = degrees_of_freedom(solved);
  const ResidualBias by_cell = cells.bias(2, freedom, least_sigma);
  const ResidualBias by_ring = rings.bias(1, freedom / 2, least_sigma);
  return {std::max(by_cell.rms_px, by_ring.rms_px), by_cell.disagree || by_ring.disagree};
}

std::optional<HalvesCheck> compare_lenses(const Bundle& solved, const VectorXd& difference,
                                          const MatrixXd& covariance,
                                          std::span<const Vector2d> samples, double distance_m) {
  const UncertainCamera lens{solved.model, {solved.lens(), solved.image_size}, covariance};
  HalvesCheck check;
  for (const double distance : {kInfinitelyFar, distance_m}) {
    const MatrixXd projection = aligned_jacobian(lens, samples, distance);
    if (projection.rows() == 0) return std::nullopt;
    const auto rms = [&](double sum) {
      return std::sqrt(sum / static_cast<double>(projection.rows()));
    };
    const double found = rms((projection * difference).squaredNorm());
    const double predicted = rms((projection * covariance).cwiseProduct(projection).sum());
    const double ratio = predicted > 0 ? found / predicted : 0;
    constexpr double kMore = 1.001;  // numeric: with one parameter all ratios are equal
    if (distance == kInfinitelyFar || ratio > kMore * check.ratio)
      check = {"", distance, found, predicted, ratio, false};
  }
  const auto inverse = exact_inverse(covariance);
  if (!inverse) return check;
  const double chi_square = difference.dot(*inverse * difference);
  const auto freedom = static_cast<double>(difference.size());
  // A principal point that differs by many of its sds is hidden in a projection of which the focal
  // length is known worse.
  check.ratio = std::max(check.ratio, std::sqrt(chi_square / freedom));
  check.disagree = check.ratio > policy::kHalvesDisagree &&
                   chi_square > chi_square_quantile(freedom, policy::kQuantile1e3);
  return check;
}

std::optional<HalvesCheck> split_half_check(const Bundle& solved,
                                            const BundleInformation& information, double sigma,
                                            std::span<const Vector2d> samples, double distance_m) {
  const Eigen::Index k = solved.model->num_free();
  const std::vector<ViewInformation> poses = information.samples();
  if (std::ssize(poses) < 2 * policy::kFewestComparedViews || k == 0) return std::nullopt;
  const double variance = sigma * sigma;
  std::array<MatrixXd, 2> halves = {information.prior, information.prior};
  std::array<VectorXd, 2> gradients = {information.prior_gradient, information.prior_gradient};
  for (std::size_t s = 0; s < poses.size(); ++s) {
    halves[s % 2] += poses[s].schur / variance;
    gradients[s % 2] += poses[s].gradient / variance;
  }
  const auto first = exact_inverse(halves[0]), second = exact_inverse(halves[1]);
  if (!first || !second) return std::nullopt;
  const VectorXd difference = (*second * gradients[1] - *first * gradients[0]).head(k);
  return compare_lenses(solved, difference, (*first + *second).topLeftCorner(k, k), samples,
                        distance_m);
}

}  // namespace tagcal::internal
