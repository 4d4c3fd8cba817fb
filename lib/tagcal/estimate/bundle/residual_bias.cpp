#include "tagcal/estimate/bundle/residual_bias.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr int kColumns = 12, kRows = 8;
constexpr int kRings = 16;
constexpr int kFewestOfGroup = 8;
constexpr int kFewestGroups = 4;
constexpr double kNormalQuantile = 3.72;  // p = 0.0001
constexpr double kSmallestFieldPx = 0.02;

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
      const Vector2d pixel = view.correspondences[i].pixel, beside = pixel - centre;
      const Vector2d r = residuals[i];
      const double radius = beside.norm();
      all.push_back({view.whitening.empty() ? r : Vector2d(view.whitening[i] * r), r, pixel,
                     radius > 0 ? Vector2d(beside / radius) : beside, radius});
    }
  }
  return all;
}

// The sums of one group of as many coordinates a corner.
struct Group {
  int count = 0;
  Vector2d whitened = Vector2d::Zero(), px = Vector2d::Zero();

  void add(const Vector2d& of_whitened, const Vector2d& of_px) {
    ++count;
    whitened += of_whitened;
    px += of_px;
  }
  void add(const Group& other) {
    count += other.count;
    whitened += other.whitened;
    px += other.px;
  }
};

// Chi-square of the groups' means against the noise within them. `coordinates`: of each mean.
ResidualField field_of(const std::vector<Group>& groups, int coordinates, double total,
                       double freedom, double least_sigma) {
  double between = 0, square_px = 0;
  int corners = 0, taken = 0;
  for (const Group& group : groups) {
    if (group.count < kFewestOfGroup) continue;
    ++taken;
    corners += group.count;
    between += group.whitened.squaredNorm() / group.count;
    square_px += group.px.squaredNorm() / group.count;
  }
  ResidualField field;
  const double k = coordinates * taken, rest = freedom - k;
  if (taken < kFewestGroups || rest < 2 * k) return field;
  const double variance = std::max((total - between) / rest, least_sigma * least_sigma);
  const double chi_square = between / variance;
  // The noise is known no better than from the rest.
  const double bound =
      chi_square_quantile(k, kNormalQuantile) * (1 + kNormalQuantile * std::sqrt(2 / rest));
  const double share = std::max(0.0, 1 - k / chi_square);  // that is not noise
  field.rms_px = chi_square > 0 ? std::sqrt(share * square_px / corners) : 0;
  field.disagree = chi_square > bound && field.rms_px > kSmallestFieldPx;
  if (field.disagree) field.inflation = std::max(1.0, between / k / (total / freedom));
  return field;
}

std::vector<Group> cells(const std::vector<Residual>& residuals, const ImageSize& size) {
  std::vector<Group> groups(kColumns * kRows);
  for (const Residual& r : residuals) {
    const int column = static_cast<int>(kColumns * (r.pixel.x() + 0.5) / size.width);
    const int row = static_cast<int>(kRows * (r.pixel.y() + 0.5) / size.height);
    const int cell = kColumns * std::clamp(row, 0, kRows - 1) + std::clamp(column, 0, kColumns - 1);
    groups[static_cast<std::size_t>(cell)].add(r.whitened, r.px);
  }
  return groups;
}

// Of as many corners each, to within those of a thin ring.
std::vector<Group> rings(const std::vector<Residual>& residuals) {
  constexpr int kThinRings = 1024;
  double largest = 0;
  for (const Residual& r : residuals) largest = std::max(largest, r.radius_px);
  std::vector<Group> thin(kThinRings);
  for (const Residual& r : residuals) {
    const int ring = static_cast<int>(kThinRings * r.radius_px / std::max(largest, 1e-300));
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

ResidualField residual_field(const Bundle& solved, double least_sigma) {
  const std::vector<Residual> residuals = residuals_of(solved);
  double total = 0, radial = 0;
  for (const Residual& r : residuals) {
    total += r.whitened.squaredNorm();
    radial += std::pow(r.whitened.dot(r.outward), 2);
  }
  const auto n = static_cast<double>(residuals.size());
  const double lost = 6.0 * static_cast<double>(solved.views.size()) + solved.model->num_free();
  const ResidualField of_cells =
      field_of(cells(residuals, solved.image_size), 2, total, 2 * n - lost, least_sigma);
  const ResidualField of_rings = field_of(rings(residuals), 1, radial, n - 0.5 * lost, least_sigma);
  return {std::max(of_cells.rms_px, of_rings.rms_px), of_cells.disagree || of_rings.disagree,
          std::max(of_cells.inflation, of_rings.inflation)};
}

}  // namespace tagcal::internal
