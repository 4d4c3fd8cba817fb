#pragma once

#include <optional>
#include <string>

#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::tools {

// A camera of a file with its uncertainty, and the pose of one of its views.
struct LensInput {
  UncertainCamera camera;                 // without a model if the file has no covariance
  std::optional<Pose> camera_from_world;  // of the view
  std::string uncertainty;                // a sentence: where the covariance comes from, or that
                                          // there is none
};

// `view`: the name of a picture in the file, or "".
LensInput read_lens(const std::string& file, const std::string& view);

// camera_from_world of a picture in a camera file. Throws Error for an unknown name.
Pose pose_of_view(const std::string& file, const std::string& name);

}  // namespace tagcal::tools
