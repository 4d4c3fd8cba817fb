#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// A picture of about 160 px for each whole number of pixels, for the comparison with the next one.
struct ReducedPicture {
  ReducedPicture() = default;
  explicit ReducedPicture(const ImageView8& image);

  ImageSize size;  // of the picture itself
  int factor = 1;  // pixels of the picture a pixel
  Image8 pixels;
};

// The shift of a part of one picture in the next one. The pictures must outlive it.
class PictureShift {
 public:
  PictureShift(const ReducedPicture& before, const ReducedPicture& now)
      : before_(before), now_(now) {}

  // The shift at which the pixels in the box are most similar, up to an eighth of the picture's
  // longer side; good to half a pixel of the reduced picture. No value if they are nowhere similar,
  // or hardly in the picture.
  std::optional<Eigen::Vector2d> of(const Eigen::AlignedBox2d& box) const;

 private:
  const ReducedPicture& before_;
  const ReducedPicture& now_;
};

}  // namespace tagcal::internal
