#pragma once

#include <string>

#include "job/view_report.hpp"

// The panels of the drawing of `tagcal view`: SVG groups with their own coordinates, in pixels from
// the upper left corner. Elements with an `id` carry the positions that tests check.

namespace tagcal::tools {

struct PanelSize {
  double width = 0;
  double height = 0;
};

// The scene from outside: objects, frames, the camera's view volume, the line of sight.
std::string scene_panel(const ViewReport& report, const PanelSize& size);

// The image of the camera.
std::string image_panel(const ViewReport& report, const PanelSize& size);

// The canonical volume (NDC) and the part of the scene in it, as a cabinet projection.
std::string ndc_panel(const ViewReport& report, const PanelSize& size);

// A drawing, SVG: the scene with the camera's view volume, the image, and the canonical volume.
std::string view_svg(const ViewReport& report);

}  // namespace tagcal::tools
