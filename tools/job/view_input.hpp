#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/moving_scene.hpp"

namespace tagcal::tools {

struct ViewChoice {
  std::string input;   // a scene, the folder of a data set, or a calibration
  std::string camera;  // a calibration for a data set; "": the truth's camera and poses
  int view = 0;
  int seed = -1;  // of a scene's jitter; -1: not given
};

// One camera, and the scene in front of it: that of a data set has boards only, that of a
// calibration nothing.
struct ViewInput {
  MovingScene scene;
  std::string image;                      // the name of the view, or of the calibration
  std::optional<Pose> camera_from_world;  // none: the view does not determine it
  std::vector<std::string> warnings;
};

// Recognises the kind of input by itself. Throws Error.
ViewInput read_view_input(const ViewChoice& choice);

}  // namespace tagcal::tools
