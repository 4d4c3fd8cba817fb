#pragma once

#include <string>

#include "job/view_report.hpp"

namespace tagcal::tools {

// A drawing, SVG: the scene with the camera's view volume, the image, and the canonical volume.
std::string view_svg(const ViewReport& report);

}  // namespace tagcal::tools
