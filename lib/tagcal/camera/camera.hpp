#pragma once

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

}  // namespace tagcal
