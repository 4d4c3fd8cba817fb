#pragma once

#include <string>

#include "study/plot/drawing.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/lens_fit.hpp"

// Values in pixels over an image, as colours on a logarithmic scale: blue, green, yellow, red. The
// drawings are 640 units wide.

namespace tagcal::tools {

// The difference between a fitted lens and its source over the image, with numbers, the hull of
// `seen` and the scale. Red: from 10 px on, without a projection, and without a ray. Precondition:
// the fit has a grid of differences.
study::Drawing lens_fit_drawing(const LensFit& fit, const SeenRegion& seen);

// The projection's standard deviation over the image, one panel per distance below each other, with
// numbers, the hull of the corners and the scale. Preconditions: calibration.projection is not
// empty, calibration.camera has a value.
study::Drawing uncertainty_drawing(const Calibration& calibration);

std::string distance_text(double distance_m);  // "infinity" or "1.2 m"

}  // namespace tagcal::tools
