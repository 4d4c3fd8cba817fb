#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// A picture of a fisheye camera as a pinhole camera along its axis would see it, small and wide:
// the lens is one with equal angles a pixel, of a focal length in longer sides of the picture.
class PinholePicture {
 public:
  PinholePicture(const ImageView8& picture, double focal_sides);

  const Image8& image() const { return image_; }
  // The place in the picture; no value if it is outside.
  std::optional<Eigen::Vector2d> in_picture(const Eigen::Vector2d& pixel) const;

 private:
  ImageSize size_;
  double focal_px_;
  Image8 image_;
};

}  // namespace tagcal::internal
