#include "tagcal/estimate/bundle/residual_bias.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr int kColumns = policy::kBiasColumns, kRows = policy::kBiasRows;
constexpr int kRings = policy::kBiasRings;

struct Residual {
  Vector2d whitened;
  Vector2d px;
  Vector2d pixel;
  Vector2d outward;  // unit, from the principal point
  double radius_px = 0;
};

std::vector<Residual> residuals_of(const Bundle& bundle) {
  const Lens lens = bundle.lens();
  const std::span<const double> values = parameters(lens);
  const Vector2d centre(values[kCx], values[kCy]);
  std::vector<Residual> all;
  all.reserve(static_cast<std::size_t>(num_corners(bundle)));
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const ViewProblem& view = bundle.views[v];
    const auto residuals = residuals_px(view.correspondences, lens, bundle.camera_from_target[v]);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const Vector2d pixel = view.correspondences[i].pixel, from_centre = pixel - centre;
      const Vector2d r = residuals[i];
      const double radius = from_centre.norm();
      all.push_back({view.whitening.empty() ? r : Vector2d(view.whitening[i] * r), r, pixel,
                     radius > 0 ? Vector2d(from_centre / radius) : from_centre, radius});
    }
  }
  return all;
}

// Sums over the corners of one group. A radial part stands in x; y is 0 then.
struct Group {
  int count = 0;
  Vector2d whitened = Vector2d::Zero(), px = Vector2d::Zero();

  void add(const Vector2d& whitened_residual, const Vector2d& residual_px) {
    ++count;
    whitened += whitened_residual;
    px += residual_px;
  }
  void add(const Group& other) {
    count += other.count;
    whitened += other.whitened;
    px += other.px;
  }
};

// Chi-square test of the groups' means against the noise within the groups. `coordinates`: those
// of each mean (2, or 1 for radial parts); `total`: sum of all squares; `freedom`: of that sum.
ResidualBias bias_of_groups(const std::vector<Group>& groups, int coordinates, double total,
                            double freedom, double least_sigma) {
  double between = 0, square_px = 0;
  int corners = 0, num_groups = 0;
  for (const Group& group : groups) {
    if (group.count < policy::kLeastBiasCorners) continue;
    ++num_groups;
    corners += group.count;
    between += group.whitened.squaredNorm() / group.count;
    square_px += group.px.squaredNorm() / group.count;
  }
  ResidualBias bias;
  const double k = coordinates * num_groups, rest = freedom - k;
  if (num_groups < policy::kLeastBiasGroups || rest < policy::kBiasFreedomRatio * k) return bias;
  const double variance = std::max((total - between) / rest, least_sigma * least_sigma);
  const double chi_square = between / variance;
  // The second factor is the uncertainty of the variance, which has `rest` degrees of freedom.
  const double bound = chi_square_quantile(k, policy::kQuantile1e4) *
                       (1 + policy::kQuantile1e4 * std::sqrt(2 / rest));
  const double bias_share = std::max(0.0, 1 - k / chi_square);  // of the squared means; rest: noise
  bias.rms_px = chi_square > 0 ? std::sqrt(bias_share * square_px / corners) : 0;
  bias.disagree = chi_square > bound && bias.rms_px > policy::kLeastBiasPx;
  if (bias.disagree) bias.inflation = std::max(1.0, between / k / (total / freedom));
  return bias;
}

std::vector<Group> cells(const std::vector<Residual>& residuals, const ImageSize& size) {
  std::vector<Group> groups(kColumns * kRows);
  const Vector2d half_pixel = Vector2d::Constant(0.5);  // numeric: the image begins at -0.5
  for (const Residual& r : residuals) {
    const Vector2d from_border = r.pixel + half_pixel;
    const int column = static_cast<int>(kColumns * from_border.x() / size.width);
    const int row = static_cast<int>(kRows * from_border.y() / size.height);
    const int cell = kColumns * std::clamp(row, 0, kRows - 1) + std::clamp(column, 0, kColumns - 1);
    groups[static_cast<std::size_t>(cell)].add(r.whitened, r.px);
  }
  return groups;
}

// Rings of equal numbers of corners, up to those of one thin ring. Radial parts only.
std::vector<Group> rings(const std::vector<Residual>& residuals) {
  constexpr int kThinRings = 1024;
  double largest = 0;
  for (const Residual& r : residuals) largest = std::max(largest, r.radius_px);
  std::vector<Group> thin(kThinRings);
  for (const Residual& r : residuals) {
    const int ring = static_cast<int>(kThinRings * r.radius_px /
                                      std::max(largest, 1e-300));  // numeric: no division by zero
    thin[static_cast<std::size_t>(std::min(ring, kThinRings - 1))].add(
        {r.whitened.dot(r.outward), 0}, {r.px.dot(r.outward), 0});
  }
  std::vector<Group> groups(kRings);
  std::size_t count = 0;
  for (const Group& ring : thin) {
    if (ring.count == 0) continue;
    groups[count * kRings / residuals.size()].add(ring);
    count += static_cast<std::size_t>(ring.count);
  }
  return groups;
}

}  // namespace

ResidualBias residual_bias(const Bundle& solved, double least_sigma) {
  const std::vector<Residual> residuals = residuals_of(solved);
  double total = 0, radial = 0;
  for (const Residual& r : residuals) {
    total += r.whitened.squaredNorm();
    radial += std::pow(r.whitened.dot(r.outward), 2);
  }
  const auto n = static_cast<double>(residuals.size());
  const double estimated = 6.0 * static_cast<double>(solved.views.size()) + solved.num_parameters();
  const ResidualBias of_cells =
      bias_of_groups(cells(residuals, solved.image_size), 2, total, 2 * n - estimated, least_sigma);
  const ResidualBias of_rings =
      bias_of_groups(rings(residuals), 1, radial, n - estimated / 2, least_sigma);
  return {std::max(of_cells.rms_px, of_rings.rms_px), of_cells.disagree || of_rings.disagree,
          std::max(of_cells.inflation, of_rings.inflation)};
}

}  // namespace tagcal::internal
