#pragma once

#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "tagcal/estimate/handeye_types.hpp"

// Poses of a robot's hand as robots and their recorders write them.

namespace tagcal {

// In metres; the hand in the frame of the robot's base. Poses belong to pictures by name, by time,
// or, without both, by their order.
struct RobotPoses {
  std::vector<std::string> images;  // one for each pose, or none
  std::vector<double> times_s;      // the same, strictly increasing
  std::vector<Pose> base_from_hand;
  RobotForm form;                          // of the file
  std::vector<RotationNumbers> rotations;  // for each pose as the file has it, but for matrices
};

// Reads a table, or a folder with one YAML file a pose (ViSP's pose vectors: x y z in metres,
// rotation vector in radians), in the order of the numbers in their names.
// A table has one line a pose, with commas or blanks between its columns; lines with # are
// comments. `columns` says what they are; "" takes the first line of the file, or TUM (`tum`) for
// lines of eight numbers. Columns:
//   image; time_s, time_ms, time_us or time_ns;
//   x_m y_m z_m, or _mm;
//   qw qx qy qz, in any order; or a rotation vector rx_rad ry_rad rz_rad, or _deg; or roll_rad
//   pitch_rad yaw_rad, or _deg, with R = R_z(yaw) R_y(pitch) R_x(roll); or the rows of a matrix
//   m00 m01 m02 m10 .. m22 (and m03_m m13_m m23_m, or _mm, in the place of x y z);
//   - for a column that does not matter, and any other name in a file's first line.
// In a file's first line the names of ROS are known, too, whose units are metres: stamps in ns of
// `rostopic echo -p`, .. translation.x or position.x, .. rotation.x or orientation.x.
// Throws Error, with file and line: a column that is missing, twice or without a unit, a number
// that is not finite, a quaternion that is not of unit length (0.1 %), a matrix that is no
// rotation, a picture with two poses, times that do not increase.
RobotPoses read_robot_poses(const std::filesystem::path& file, const std::string& columns = "");

// The number of digits of the last number in the name of a file (without zeros in front; 0: none),
// these digits, and the name: orders pose_2 before pose_10, for numbers of any length.
std::tuple<std::size_t, std::string, std::string> order_of_numbers(
    const std::filesystem::path& file);

}  // namespace tagcal
