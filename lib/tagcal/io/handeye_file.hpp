#pragma once

#include <string>

#include "tagcal/estimate/handeye_types.hpp"

namespace tagcal {

// "hand" or "base"; the frame at the other end of the robot is the holder of the board.
std::string mount_name(CameraMount mount);
std::string holder_name(CameraMount mount);

// handeye.yaml (docs/reference/formats.md): the places of camera and board with their covariances,
// the robot's noise and findings. Precondition: is_answer(handeye.status).
std::string handeye_yaml(const HandeyeEstimate& handeye);

// The camera's place as a static transform of ROS (geometry_msgs/TransformStamped in YAML, from the
// frame of the mount to `camera`), with the command that publishes it. Precondition as above.
std::string handeye_ros_text(const HandeyeEstimate& handeye);

}  // namespace tagcal
