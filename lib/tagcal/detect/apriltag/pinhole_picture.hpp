#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/camera/lens.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// A picture of a fisheye camera as a pinhole camera along its axis would see it, small and wide.
// The lens must outlive it.
class PinholePicture {
 public:
  PinholePicture(const ImageView8& picture, const Lens& lens);

  const Image8& image() const { return image_; }
  // The place in the picture; no value if it is outside.
  std::optional<Eigen::Vector2d> in_picture(const Eigen::Vector2d& pixel) const;

 private:
  ImageSize size_;
  const Lens& lens_;
  Image8 image_;
};

}  // namespace tagcal::internal
