#pragma once

#include "tagcal/scene/image.hpp"

// Private to detect: filters by OpenCV. Precondition: pictures that are not empty.
namespace tagcal::internal {

// Replaces each pixel by its brightest neighbour up to `radius` away in x and y: black shrinks by
// `radius`.
Image8 brightest(const ImageView8& image, int radius);

// Smooths with the binomial filter 1 4 6 4 1 in both directions: a Gaussian of 1 px. The sums are
// exact.
ImageF smoothed(const ImageView8& image);

}  // namespace tagcal::internal
