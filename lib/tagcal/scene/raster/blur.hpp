#pragma once

#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::internal {

// From a raster `scale` times finer than the image to pixels that sample a Gaussian blur (standard
// deviation blur_px > 0, in pixels) of it: first every row of the raster, then the columns. What is
// beyond the border repeats the last cell.
class Blur {
 public:
  Blur(double blur_px, int scale);

  // One row: `cells` holds scale * num_pixels.
  void filter_row(const float* cells, int num_pixels, float* pixels);

  // `rows` holds scale * height rows.
  ImageF filter_columns(const ImageF& rows) const;

 private:
  int scale_;
  int first_;  // of the cells that weights_ are for, counted from the pixel's first
  std::vector<float> weights_;
  std::vector<float> padded_;
};

}  // namespace tagcal::internal
