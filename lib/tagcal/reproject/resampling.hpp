#pragma once

#include <type_traits>

#include "tagcal/reproject/types.hpp"
#include "tagcal/scene/image.hpp"

// New pictures from old ones, through a map of pixels.

namespace tagcal {

enum class Interpolation {
  nearest,   // the value of the nearest pixel
  bilinear,  // of 2 x 2 pixels
  lanczos4,  // of 8 x 8 pixels: sinc(x) sinc(x / 4) along rows and columns, sums scaled to 1
};

struct ResampleOptions {
  Interpolation interpolation = Interpolation::bilinear;
  // Where the target is coarser than the source, the kernel is widened to the size of the target
  // pixel in the source (both axes of its ellipse, by the Jacobian of the map), so that detail too
  // fine for the target is averaged instead of aliased. `nearest` never averages. False: the kernel
  // as it is, as in cv::remap.
  bool area_correct = true;
  int threads = 1;  // 0: one per core; the picture does not depend on it
};

template <typename T>
struct Resampled {
  Image<T> image;
  Image8 seen;  // 255 where the centre of the pixel is in the source picture; 0: border value
};

// T is uint8_t, uint16_t, Rgb or Rgb16. A pixel is seen if its coordinates are in [-0.5, width -
// 0.5) x [-0.5, height - 0.5); taps beyond the border of the source take the pixel at the border.
// Pixels that are not seen get the value `border`. Throws Error if the picture is not of the
// camera's size, or empty.
template <typename T>
Resampled<T> reproject(const ImageView<T>& picture, const Reprojection& reprojection,
                       const ResampleOptions& options = {},
                       const std::type_identity_t<T>& border = T());

// The same by a map, whose two images must be of one size.
template <typename T>
Resampled<T> remap(const ImageView<T>& picture, const PixelMap& map,
                   const ResampleOptions& options = {},
                   const std::type_identity_t<T>& border = T());

// The same for pictures that own their memory.
template <typename T>
Resampled<T> reproject(const Image<T>& picture, const Reprojection& reprojection,
                       const ResampleOptions& options = {},
                       const std::type_identity_t<T>& border = T()) {
  return reproject(ImageView<T>(picture), reprojection, options, border);
}
template <typename T>
Resampled<T> remap(const Image<T>& picture, const PixelMap& map,
                   const ResampleOptions& options = {},
                   const std::type_identity_t<T>& border = T()) {
  return remap(ImageView<T>(picture), map, options, border);
}

}  // namespace tagcal
