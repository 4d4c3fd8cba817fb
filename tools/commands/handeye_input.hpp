#pragma once

#include <string>

#include "job/input.hpp"
#include "report/handeye_report.hpp"
#include "tagcal/io/robot_poses.hpp"

namespace tagcal::tools {

struct HandeyeSources {
  InputArguments input;  // pictures, the folders of a rig's cameras, or a file of poses (.json)
  std::string camera;
  std::string pair = "name";
  double sigma_px = 0;
  int threads = 0;
};

// Finds the corners of the pictures, estimates the poses of a rig, or reads those of a file. Throws
// Error for options that do not belong together, and as their readers.
HandeyeInput read_handeye(const HandeyeSources& arguments);

// Gives each view the pose of the robot that belongs to its picture: by name (with or without
// folder and ending), by the order of the numbers in the names, or, of poses with times, by the
// picture's time, its own or that of the file `times` (image,time_s): then the path goes to the
// options. Throws Error: names that are unknown or missing, counts that differ, no times.
void add_robot_poses(const std::string& robot, const RobotPoses& poses, const std::string& times,
                     HandeyeInput& input, HandeyeOptions& options);

}  // namespace tagcal::tools
