#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "study/method.hpp"
#include "tagcal/estimate/handeye.hpp"
#include "tagcal/random.hpp"

// Hand-eye calibrations for studies: a camera of 1280 x 800 pixels before a board of 4 x 4 tags of
// 6 cm, 0.5 to 1.1 m away, on the hand of a robot or beside it.

namespace tagcal::study {

// The fault of the robot's poses.
enum class RobotMistake { none, inverse, millimetres, quaternion_order, shifted };

struct HandeyeKind {
  CameraMount mount = CameraMount::hand;
  int num_poses = 15;
  double turn_rad = 0.45;        // RMS rotation from pose to pose, about the main axis
  double axis_spread_rad = 0.7;  // of the rotation axes (HandeyeEstimate::axis_spread_rad), nearly
  double robot_sigma_m = 1e-3;   // per axis
  double robot_sigma_rad = 2e-3;
  double sigma_px = 0.2;
  double board_scale = 1;  // of the board, over what the methods are told
  int num_wrong = 0;       // robot poses, of the first views, that are off by
  double wrong_m = 0.03;   // in random directions
  RobotMistake mistake = RobotMistake::none;
  bool known_lens = false;  // exactly; else by a covariance from which its error is drawn
};

struct HandeyeTask {
  std::vector<HandeyeView> views;
  UncertainCamera camera;  // as the methods know it
  CameraMount mount = CameraMount::hand;
  double distance_m = 1;  // of the board, mean
  // Truth.
  Pose mount_from_camera, holder_from_board;
  std::vector<Pose> base_from_hand;  // by view
  double robot_sigma_m = 0, robot_sigma_rad = 0, sigma_px = 0;
};
HandeyeTask draw_handeye(const HandeyeKind& kind, Random& random);

// The covariance of mount_from_camera for a robot whose noise is known, at the truth: the
// Cramer-Rao bound. Empty if it is singular.
Eigen::MatrixXd handeye_bound(const HandeyeTask& task);

struct HandeyeAnswer {
  std::optional<Pose> mount_from_camera;
  bool answered = false;       // by its own words
  bool warned = false;         // of data that may not be as they should
  Eigen::MatrixXd covariance;  // of (omega, tau); empty: the method states none
  std::string said = "no answer";
};
using HandeyeMethod = Method<HandeyeTask, HandeyeAnswer>;

// `tagcal handeye`, OpenCV's five methods of calibrateHandEye and two of
// calibrateRobotWorldHandEye, the latter from solvePnP's poses of the views, whose time counts.
std::vector<HandeyeMethod> handeye_methods();

}  // namespace tagcal::study
