#pragma once

#include <filesystem>
#include <string>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/lens_fit.hpp"
#include "tagcal/scene/image.hpp"

// Values in pixels over an image, as colours on a logarithmic scale: blue, green, yellow, red.

namespace tagcal::tools {

// The difference between a fitted lens and its source over the image, with the colour scale; the
// SVG also has numbers and the hull of `seen`. Red: from 10 px on, without a projection, and
// without a ray. Precondition: the fit has a grid of differences.
std::string lens_fit_svg(const LensFit& fit, const SeenRegion& seen);
ImageRgb lens_fit_image(const LensFit& fit);

// Writes the projection's standard deviation over the image, one panel per distance below each
// other: .svg with the hull of the corners, or .png, 640 pixels wide: black up to 0.001 px, white
// from 10 px on (and without a ray), logarithmic between. Preconditions: calibration.projection is
// not empty, calibration.camera has a value.
void write_uncertainty_picture(const std::filesystem::path& file, const Calibration& calibration);

std::string distance_text(double distance_m);  // "infinity" or "1.2 m"

}  // namespace tagcal::tools
