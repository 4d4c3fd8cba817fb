#pragma once

#include <string>
#include <string_view>

#include "tagcal/io/types.hpp"

// Cameras of ROS beside its YAML file: the INI file of ROS 1, and a CameraInfo message as
// `rostopic echo` and `ros2 topic echo` print it.

namespace tagcal::internal {

bool is_ros_ini(std::string_view text);
CameraFile read_ros_ini(const std::string& text, const std::string& file);

bool is_ros_message(std::string_view text);
// The first message, if there are several.
CameraFile read_ros_message(const std::string& text, const std::string& file);

}  // namespace tagcal::internal
