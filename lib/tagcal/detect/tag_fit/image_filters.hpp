#pragma once

#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// Half as wide and high, rounded down: each pixel the mean of four. Precondition: 2x2 at least.
Image8 halved(const ImageView8& image);

// Twice as wide and high, by cubic convolution (Keys, IEEE ASSP 1981), which reproduces linear and
// quadratic functions.
Image8 doubled(const ImageView8& image);

// A rectangle of pixels, part of a picture.
struct PixelBox {
  int left = 0;
  int top = 0;
  ImageSize size;
};

Image8 part_of(const ImageView8& image, const PixelBox& box);

// A picture to search. The four phases of a raw mosaic are brought to one level: a Bayer sensor has
// a green, red or blue filter before each pixel, so bright, grey paper has a level of its own in
// each of them. A picture of two levels, from a scanner, copier or threshold, is smoothed: borders
// sharper than a pixel, between levels that look clipped, keep fits from converging. Other pictures
// stay.
struct PictureToSearch {
  explicit PictureToSearch(const ImageView8& image);  // which must outlive it
  PictureToSearch(const PictureToSearch&) = delete;
  PictureToSearch& operator=(const PictureToSearch&) = delete;

  ImageView8 pixels;
  double gain = 1;  // the largest one of a mosaic's phase

 private:
  Image8 changed_;
};

// Standard deviation of a pixel's noise in the smooth parts of a picture, grey levels.
double noise_of(const ImageView8& image);

}  // namespace tagcal::internal
