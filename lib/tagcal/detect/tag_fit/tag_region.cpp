#include "tagcal/detect/tag_fit/tag_region.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// Corners 0..3 on the tag's plane.
constexpr std::array<std::array<double, 2>, 4> kCorners = {{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};

struct Range {
  double low = 0;
  double high = 0;
};

// The lines within a range, with a line at either end of it; `first_cell` is the first cell's
// index.
std::vector<double> cut_lines(const std::vector<double>& lines, const Range& range,
                              std::size_t& first_cell) {
  const double low = std::max(range.low, lines.front());
  const double high = std::min(range.high, lines.back());
  std::vector<double> result = {low};
  first_cell = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] <= low) first_cell = i;
    if (lines[i] > low && lines[i] < high) result.push_back(lines[i]);
  }
  result.push_back(high);
  return result;
}

TagGrid cut(const std::vector<double>& columns, const std::vector<double>& rows,
            const std::vector<TagPattern::Cell>& cells, const Range& across, const Range& down) {
  TagGrid grid;
  std::size_t column = 0, row = 0;
  grid.columns = cut_lines(columns, across, column);
  grid.rows = cut_lines(rows, down, row);
  const std::size_t n = columns.size() - 1;
  for (std::size_t j = 0; j + 1 < grid.rows.size(); ++j)
    for (std::size_t i = 0; i + 1 < grid.columns.size(); ++i)
      grid.cells.push_back(cells[(row + j) * n + column + i]);
  return grid;
}

TagGrid cut(const TagPattern& pattern, const Range& across, const Range& down) {
  return cut(pattern.lines, pattern.lines, pattern.cells, across, down);
}

// The range around a corner at 0 or 1 of a side of the given length, px.
Range about(double corner, double side_px) {
  const double outside = policy::kTagOutsidePx / side_px;
  const double inside = std::min(1.0 / 2, policy::kTagInsidePx / side_px);
  return corner == 0 ? Range{-outside, inside} : Range{1 - inside, 1 + outside};
}

// Counts the places on the tag from another origin in other units.
void change_units(TagRegion& region, const Vector2d& origin, const Vector2d& per_side) {
  for (double& at : region.grid.columns) at = (at - origin.x()) * per_side.x();
  for (double& at : region.grid.rows) at = (at - origin.y()) * per_side.y();
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d place(kCorners[i][0], kCorners[i][1]);
    region.corners_on_tag[i] = (place - origin).cwiseProduct(per_side);
  }
}

}  // namespace

double mean_half_side(const TagCorners& corners) {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += (corners[(i + 1) % 4] - corners[i]).norm();
  return sum / 8;
}

TagRegion whole_tag(const TagPattern& pattern, const TagCorners& corners) {
  const double scale = mean_half_side(corners);
  const double outside = policy::kTagOutsidePx / 2 / scale;
  const Range range{-outside, 1 + outside};
  TagRegion region{cut(pattern, range, range), {}, Vector2d::Zero(), scale, {}};
  for (const Vector2d& corner : corners) region.middle += corner / 4;
  change_units(region, Vector2d::Constant(1.0 / 2), Vector2d(2, 2));
  return region;
}

TagRegion part_of_tag(const TagPattern& pattern, const TagCorners& corners, std::size_t corner) {
  const auto [u, v] = kCorners[corner];
  // Corners 0 and 1, 2 and 3 differ in u; 1 and 2, 3 and 0 in v.
  const Vector2d along_u = corners[corner ^ 1U] - corners[corner];
  const Vector2d along_v = corners[3 - corner] - corners[corner];
  const Range across = about(u, along_u.norm()), down = about(v, along_v.norm());
  const double share_u = across.high - across.low, share_v = down.high - down.low;
  const Vector2d middle = corners[corner] + std::abs((across.low + across.high) / 2 - u) * along_u +
                          std::abs((down.low + down.high) / 2 - v) * along_v;
  const double scale = (share_u * along_u.norm() + share_v * along_v.norm()) / 4;
  TagRegion region{cut(pattern, across, down), {}, middle, scale, corner};
  // One unit for both directions, as on the whole tag: ink that spreads is foreshortened as it is.
  change_units(region, Vector2d(u, v), Vector2d::Constant(2 * mean_half_side(corners) / scale));
  return region;
}

CornerRegion about_corner(const CornerPattern& pattern, const Eigen::Matrix3d& image_from_pattern) {
  const auto pixel = [&](double x, double y) -> Vector2d {
    return (image_from_pattern * Eigen::Vector3d(x, y, 1)).hnormalized();
  };
  constexpr double kDelta = 1e-3;  // numeric: of differences, small against a square
  const double unit_x = (pixel(kDelta, 0) - pixel(-kDelta, 0)).norm() / (2 * kDelta);
  const double unit_y = (pixel(0, kDelta) - pixel(0, -kDelta)).norm() / (2 * kDelta);
  const double reach_x = policy::kTagInsidePx / unit_x, reach_y = policy::kTagInsidePx / unit_y;
  CornerRegion result{
      {cut(pattern.columns, pattern.rows, pattern.cells, {-reach_x, reach_x}, {-reach_y, reach_y}),
       {Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1)},
       pixel(0, 0),
       1,
       0},
      {}};
  TagGrid& grid = result.region.grid;
  const double half_x = (grid.columns.back() - grid.columns.front()) / 2;
  const double half_y = (grid.rows.back() - grid.rows.front()) / 2;
  result.region.scale = (half_x * unit_x + half_y * unit_y) / 2;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d& at = result.region.corners_on_tag[i];
    result.start[i] = pixel(at.x() * half_x, at.y() * half_y);
  }
  for (double& at : grid.columns) at /= half_x;
  for (double& at : grid.rows) at /= half_y;
  return result;
}

}  // namespace tagcal::internal
