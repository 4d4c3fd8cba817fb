#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// One camera of a rig, with what it saw.
struct RigCamera {
  std::string name;             // for people and files; cameras are told apart by their index
  Dataset data;                 // its boards are those of the rig's other cameras
  std::vector<double> times_s;  // of the views, on the camera's own clock; empty: not known
};

// The views that the cameras of a rig took at one instant: the index in RigCamera::data.views for
// each camera, no value for a camera without a view.
struct Instant {
  std::vector<std::optional<std::size_t>> view;  // by camera
};

// The true extrinsics of a synthetic rig: the camera frames in one frame of the rig.
struct RigTruth {
  std::vector<Pose> camera_from_rig;  // by camera
  // By camera: its pictures were taken that much later than their stamps say on the rig's clock.
  std::vector<double> time_offset_s;
};

// Cameras on one rigid body that see the same boards.
struct RigDataset {
  std::vector<RigCamera> cameras;
  std::vector<Instant> instants;  // in the order of time
  std::optional<RigTruth> truth;
};

}  // namespace tagcal
