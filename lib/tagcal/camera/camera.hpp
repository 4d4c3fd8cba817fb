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

// Whether a pixel lies in the image: [-0.5, width - 0.5) x [-0.5, height - 0.5).
bool contains(const ImageSize& size, const Eigen::Vector2d& pixel);

// The centre of the image, ((width - 1) / 2, (height - 1) / 2).
Eigen::Vector2d image_centre(const ImageSize& size);

// Field of view <-> focal length of a pinhole, along an extent of `extent_px` pixels (the width,
// the height, or the diagonal) with the principal point in its middle: fov = 2 atan(extent / 2 f).
// Domain: 0 < fov < pi, f > 0.
double focal_from_field_of_view_px(double field_of_view_rad, double extent_px);
double field_of_view_rad(double focal_px, double extent_px);

// The same pinhole's angle across another extent, pixels square (vertical from horizontal: from W
// to H; diagonal: to hypot(W, H); only the ratio counts): 2 atan(tan(fov / 2) to / from).
double field_of_view_rad(double field_of_view_rad, double from_extent, double to_extent);

// Angles between the rays through the outer border of the image: across and down through the
// principal point, and from the upper left to the lower right corner. For a pinhole with its
// principal point in the middle they are 2 atan(W / 2 fx), 2 atan(H / 2 fy), ... A fisheye's are
// measured through the optical axis and may exceed pi.
struct FieldOfView {
  double horizontal_rad = 0;
  double vertical_rad = 0;
  double diagonal_rad = 0;
};

// No value for parallel rays, or where a point of the border has no ray.
std::optional<FieldOfView> field_of_view(const Camera& camera);

// Whether a rational distortion has a pole (a vanishing denominator) within the normalised radius
// of a corner of the image: that of its ray, or that of its pixel without distortion, up to which
// an undistorted image of the same focal length evaluates the lens.
bool has_pole(const Camera& camera);

}  // namespace tagcal
