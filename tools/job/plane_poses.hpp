#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tagcal/io/types.hpp"

namespace tagcal::tools {

struct PlaneRequest {
  std::string camera;                     // the name of a camera file,
  const CalibrationFile* file = nullptr;  // and its content
  std::string target;                     // a target file; "": none
  std::string view;                       // a view of the camera file; "": the target is detected
  std::vector<std::string> images;        // pictures
  int threads = 0;
};

struct PlanePoses {
  // Index of the picture, and its pose; with a view, that one for all pictures. Pictures without an
  // answer are not there, but in `warnings`.
  std::vector<std::pair<std::size_t, Pose>> camera_from_plane;
  std::vector<double> rectangle;  // x0, y0, x1, y1: of the target, and a tenth more; else empty
  std::vector<std::string> warnings;
};

// Throws Error for bad input.
PlanePoses plane_poses(const PlaneRequest& request);

}  // namespace tagcal::tools
