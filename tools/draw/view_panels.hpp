#pragma once

#include "job/view_report.hpp"
#include "study/plot/drawing.hpp"

// The panels of the drawing of `tagcal view`.

namespace tagcal::tools {

struct PanelSize {
  double width = 0;
  double height = 0;
};

// The scene from outside: objects, frames, the camera's view volume, the line of sight.
study::Drawing scene_panel(const ViewReport& report, const PanelSize& size);

// The image of the camera, in a frame.
study::Drawing image_panel(const ViewReport& report, const PanelSize& size);

// The canonical volume (NDC) and the part of the scene in it, as a cabinet projection.
study::Drawing ndc_panel(const ViewReport& report, const PanelSize& size);

// All three, and the coordinates of the point.
study::Drawing view_drawing(const ViewReport& report);

}  // namespace tagcal::tools
