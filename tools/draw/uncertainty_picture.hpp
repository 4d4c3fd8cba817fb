#pragma once

#include <filesystem>
#include <string>

#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// Writes the projection's standard deviation over the image, one panel per distance below each
// other: .svg with the hull of the corners, or .png, 640 pixels wide: black up to 0.001 px, white
// from 10 px on (and without a ray), logarithmic between. Preconditions: calibration.projection is
// not empty, calibration.camera has a value.
void write_uncertainty_picture(const std::filesystem::path& file, const Calibration& calibration);

std::string distance_text(double distance_m);  // "infinity" or "1.2 m"

}  // namespace tagcal::tools
