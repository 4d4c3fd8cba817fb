#pragma once

#include <string>

#include "study/plot/drawing.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// A drawing on white, by cairo.
std::string drawing_svg(const study::Drawing& drawing);
ImageRgb drawing_image(const study::Drawing& drawing, double pixels_per_unit);

}  // namespace tagcal::tools
