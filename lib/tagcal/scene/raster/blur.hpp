#pragma once

#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::internal {

// Applies a Gaussian blur (standard deviation blur_px > 0, in pixels) to a raster `scale` times
// finer than the image and samples it at the pixels: first every row of the raster, then the
// columns. The last cell is repeated beyond the border.
class Blur {
 public:
  Blur(double blur_px, int scale);

  // Blurs one row: `cells` has scale * num_pixels values.
  void filter_row(const float* cells, int num_pixels, float* pixels);

  // Blurs the columns: `rows` has scale * height rows.
  ImageF filter_columns(const ImageF& rows) const;

 private:
  int scale_;
  int first_;  // of the cells that weights_ are for, counted from the pixel's first
  std::vector<float> weights_;
  std::vector<float> padded_;
};

}  // namespace tagcal::internal
