#pragma once

#include <optional>

#include "tagcal/camera/lens.hpp"

namespace tagcal {

struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize&) const = default;
};

// A lens and the size of the image behind it; by default the normalised camera, x' = X / Z.
struct Camera {
  Lens lens = pinhole(1, 1, 0, 0);
  ImageSize image_size;
};

// Returns true if the pixel lies in the image: [-0.5, width - 0.5) x [-0.5, height - 0.5).
bool contains(const ImageSize& size, const Eigen::Vector2d& pixel);

// The centre of the image, ((width - 1) / 2, (height - 1) / 2).
Eigen::Vector2d image_centre(const ImageSize& size);

// Convert between field of view and focal length of a pinhole, along `extent_px` pixels (the width,
// the height, or the diagonal) with the principal point in the middle: fov = 2 atan(extent / 2 f).
// Domain: 0 < fov < pi, f > 0.
double focal_from_field_of_view_px(double field_of_view_rad, double extent_px);
double field_of_view_rad(double focal_px, double extent_px);

// Converts the field of view along one extent to that along another, for square pixels:
// 2 atan(tan(fov / 2) to / from). Vertical from horizontal: from W to H; diagonal: to hypot(W, H).
double field_of_view_rad(double field_of_view_rad, double from_extent, double to_extent);

// Angles between the rays through the outer border of the image: horizontal and vertical through
// the principal point, diagonal from the upper left to the lower right corner. For a pinhole with
// its principal point in the middle they are 2 atan(W / 2 fx), 2 atan(H / 2 fy), ... Those of a
// fisheye are measured through the optical axis and may exceed pi.
struct FieldOfView {
  double horizontal_rad = 0;
  double vertical_rad = 0;
  double diagonal_rad = 0;
};

// No value for parallel rays, or if a point of the border has no ray.
std::optional<FieldOfView> field_of_view(const Camera& camera);

// Returns true if a rational distortion has a pole (a vanishing denominator) within the normalised
// radius of an image corner. Both radii of a corner count: that of its ray, and that of its pixel
// without distortion, up to which an undistorted image of the same focal length evaluates the lens.
bool has_pole(const Camera& camera);

}  // namespace tagcal
