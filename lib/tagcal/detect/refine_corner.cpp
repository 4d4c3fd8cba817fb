#include "tagcal/detect/refine_corner.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

void check(const CornerPattern& pattern) {
  for (const std::vector<double>* lines : {&pattern.columns, &pattern.rows}) {
    if (lines->size() < 3 || lines->size() > kMaxTagLines ||
        !std::ranges::is_sorted(*lines, std::ranges::less_equal()) ||
        std::ranges::find(*lines, 0.0) == lines->end())
      throw Error("refine_corner: pattern: must have 3 to 24 ascending lines, one of them at 0");
  }
  if (pattern.cells.size() != (pattern.columns.size() - 1) * (pattern.rows.size() - 1))
    throw Error("refine_corner: pattern: must have a cell between each two lines");
}

// The lines within [-reach, reach], with a line at either end; `first` is the first cell's index.
std::vector<double> cut_lines(const std::vector<double>& lines, double reach, std::size_t& first) {
  const double low = std::max(-reach, lines.front()), high = std::min(reach, lines.back());
  std::vector<double> result = {low};
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] <= low) first = i;
    if (lines[i] > low && lines[i] < high) result.push_back(lines[i]);
  }
  result.push_back(high);
  return result;
}

struct Region {
  TagRegion region;
  TagCorners start;  // of the region's corners; the first one is the corner
};

Region region_of(const CornerPattern& pattern, const Eigen::Matrix3d& image_from_pattern) {
  const auto pixel = [&](double x, double y) -> Vector2d {
    return (image_from_pattern * Eigen::Vector3d(x, y, 1)).hnormalized();
  };
  constexpr double kDelta = 1e-3;  // numeric: of differences, small against a square
  const Vector2d place = pixel(0, 0);
  const double unit_x = (pixel(kDelta, 0) - pixel(-kDelta, 0)).norm() / (2 * kDelta);
  const double unit_y = (pixel(0, kDelta) - pixel(0, -kDelta)).norm() / (2 * kDelta);
  Region result{{{}, {}, place, 1, 0}, {}};
  TagGrid& grid = result.region.grid;
  std::size_t column = 0, row = 0;
  grid.columns = cut_lines(pattern.columns, policy::kTagInsidePx / unit_x, column);
  grid.rows = cut_lines(pattern.rows, policy::kTagInsidePx / unit_y, row);
  const std::size_t n = pattern.columns.size() - 1;
  for (std::size_t j = 0; j + 1 < grid.rows.size(); ++j)
    for (std::size_t i = 0; i + 1 < grid.columns.size(); ++i)
      grid.cells.push_back(pattern.cells[(row + j) * n + column + i]);
  const double half_x = (grid.columns.back() - grid.columns.front()) / 2;
  const double half_y = (grid.rows.back() - grid.rows.front()) / 2;
  result.region.scale = (half_x * unit_x + half_y * unit_y) / 2;
  result.region.corners_on_tag = {Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1)};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d& at = result.region.corners_on_tag[i];
    result.start[i] = pixel(at.x() * half_x, at.y() * half_y);
  }
  for (double& at : grid.columns) at /= half_x;
  for (double& at : grid.rows) at /= half_y;
  return result;
}

template <typename T>
CornerFit refine(const ImageView<T>& image, const CornerPattern& pattern,
                 const Eigen::Matrix3d& image_from_pattern, const TagFitOptions& options) {
  check(pattern);
  if (options.camera && options.camera->image_size != image.size())
    throw Error("refine_corner: camera: its image must have the size of the picture");
  CornerFit result;
  const Region region = region_of(pattern, image_from_pattern);
  const Vector2d& start = region.start[0];
  const auto is_in_picture = [&](const Vector2d& at) {
    return is_inside({at, at, at, at}, image.size(), 0);
  };
  result.status = TagFitStatus::out_of_image;
  if (!is_in_picture(start)) return result;
  TagFitter fitter(region.region, region.start, options);
  const TagFit fit = fitter.cut(image) ? fitter.fit() : TagFit();
  result.status = fit.status;
  result.corner = fit.corners[0];
  const Eigen::Matrix2d covariance = fit.covariance_px2.topLeftCorner<2, 2>();
  result.covariance_px2 = (covariance + covariance.transpose()) / 2;
  result.blur_px = fit.blur_px;
  result.black = fit.black;
  result.white = fit.white;
  result.noise_levels = fit.noise_levels;
  result.num_pixels = fit.num_pixels;
  if (fit.status == TagFitStatus::converged && !is_in_picture(result.corner))
    result.status = TagFitStatus::out_of_image;
  return result;
}

}  // namespace

CornerFit refine_corner(const ImageView8& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern, const TagFitOptions& options) {
  return refine(image, pattern, image_from_pattern, options);
}

CornerFit refine_corner(const ImageView16& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern, const TagFitOptions& options) {
  return refine(image, pattern, image_from_pattern, options);
}

}  // namespace tagcal
