#pragma once

#include <string>
#include <vector>

#include "job/input.hpp"
#include "tagcal/estimate/handeye.hpp"
#include "tagcal/io/robot_poses.hpp"

namespace tagcal::tools {

// Gives each view of the input the pose of the robot that belongs to its picture: by name (with or
// without folder and ending), by the order of the numbers in the names, or, of poses with times, by
// the picture's time of the file `times` (image,time_s): then the path goes to the options. Throws
// Error: names that are unknown or missing, counts that differ, no times.
std::vector<HandeyeView> with_robot_poses(const Input& input, std::vector<HandeyeView> views,
                                          const std::string& robot, const RobotPoses& poses,
                                          const std::string& times, HandeyeOptions& options);

}  // namespace tagcal::tools
