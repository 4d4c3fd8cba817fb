#pragma once

#include <string>

#include "tagcal/scene/viewing.hpp"

namespace tagcal::tools {

// One camera of a scene, its matrices, and a point followed through them.
struct ViewReport {
  const Scene& scene;
  std::string image;  // name of the view
  ViewingPipeline pipeline;
  NamedPoint point;
  FollowedPoint followed;
};

// If the point is seen, and else why not.
std::string sight_line(const FollowedPoint& followed);

std::string view_text(const ViewReport& report);
std::string view_json(const ViewReport& report);

// A drawing, SVG: the scene with the camera's frustum, and the image that it takes.
std::string view_svg(const ViewReport& report);

}  // namespace tagcal::tools
