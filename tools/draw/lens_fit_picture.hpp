#pragma once

#include <string>

#include "tagcal/estimate/lens_fit.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// The difference between a fitted lens and its source over the image, with the colour scale; the
// SVG also has numbers and the hull of `seen`. Red: from 10 px on, without a projection, and
// without a ray. Precondition: the fit has a grid of differences.
std::string lens_fit_svg(const LensFit& fit, const SeenRegion& seen);
ImageRgb lens_fit_image(const LensFit& fit);

}  // namespace tagcal::tools
