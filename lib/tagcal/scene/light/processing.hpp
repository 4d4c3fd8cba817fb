#pragma once

#include <algorithm>
#include <cmath>

#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

// What a camera does to the values of its pixels.

namespace tagcal::internal {

using Levels = Image<double>;  // from 0 to `white`

inline double clipped(double level, double white) { return std::max(0.0, std::min(level, white)); }

// A share of white, as the picture shows it.
inline double encoded(double light, double gamma) {
  return gamma == 1 ? light : std::pow(std::max(0.0, light), gamma);
}

inline bool is_processed(const Sensor& sensor) {
  return sensor.mosaic || sensor.denoise || sensor.sharpen || sensor.jpeg;
}

// Throws Error for settings out of their range, and for JPEG of 16 bits.
void check_processing(const Sensor& sensor);

// The gain of the filter of a pixel.
double filter_gain(const Mosaic& mosaic, int x, int y);

// Makes the picture of the sensor's mosaic, then applies denoising, sharpening and JPEG. Beyond the
// border of the image the nearest pixels are repeated.
void process(const Sensor& sensor, double white, Levels& levels);

}  // namespace tagcal::internal
