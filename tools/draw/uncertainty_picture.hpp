#pragma once

#include <string>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// The projection's standard deviation over the image, one panel per distance, with the hull of the
// corners. Preconditions: calibration.projection is not empty, calibration.camera has a value.
std::string uncertainty_svg(const Calibration& calibration);

// The same as a picture, panels below each other, 640 pixels wide: black up to 0.001 px, white from
// 10 px on (and without a ray), logarithmic between.
Image8 uncertainty_image(const Calibration& calibration);

std::string distance_text(double distance_m);  // "infinity" or "1.2 m"

}  // namespace tagcal::tools
