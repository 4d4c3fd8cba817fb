#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

// Options and results of calibrate_handeye (handeye.hpp).
//
// Frames: `base` is the robot's foot, `hand` what its poses describe (flange or tool). One of them
// carries the camera, the mount; the other one carries the board, the holder:
//   camera on the hand:  mount = hand, holder = base;
//   camera beside the robot:  mount = base, holder = hand.

namespace tagcal {

enum class CameraMount { hand, base };

// Poses of the hand over time.
struct RobotPath {
  std::vector<double> times_s;  // strictly increasing
  std::vector<Pose> base_from_hand;
};
// The hand at a time: between two poses the position along the chord, the rotation about one axis.
// No value outside of the path.
std::optional<Pose> hand_at(const RobotPath& path, double time_s);

// How the robot's poses were written, as far as it is known: of the ways in which they can have
// been misread, those are tried that this allows.
enum class RotationForm { unknown, wxyz, xyzw, vector, roll_pitch_yaw, matrix };
struct RobotForm {
  RotationForm rotation = RotationForm::unknown;
  double length_unit_m = 0;  // 1 or 0.001; 0: not known
  bool in_degrees = false;   // a rotation vector, or roll, pitch and yaw
};
// A rotation as it was written, in radians: w x y z, or a rotation vector, or roll, pitch and yaw.
using RotationNumbers = std::array<double, 4>;

struct HandeyeOptions {
  CameraMount mount = CameraMount::hand;
  double sigma_px = 0;  // as PoseOptions
  // The tolerance of the board's lengths (Substrate::print), the prior of its scale, which the
  // robot's motions measure. Views of poses alone have a board, too.
  Tolerance print = Material::paper;
  bool reject_outliers = true;  // views whose robot pose contradicts the others
  // With a path, the views' robot poses are those at their times; their own are not used.
  std::optional<RobotPath> path;
  RobotForm robot_form;
  // Estimates what is to be added to the views' times to get those of the path. Needs a path.
  bool find_time_offset = false;
  std::size_t num_threads = 1;  // 0: one per core; the answer does not depend on it
};

// One view of an answer.
struct HandeyeViewFit {
  std::size_t view = 0;  // index in the input
  Pose base_from_hand;   // estimated: that of the robot, corrected by the camera
  double error_m = 0;    // of the robot's pose: distance, and angle, from the estimated one
  double error_rad = 0;
  double score = 0;  // root of the chi-square of that error over its six degrees of freedom
  double rms_px = 0;
};

// Another reading of the robot's poses under which they agree with the pictures.
struct RobotReading {
  std::string change;       // "the poses are hand_from_base instead of base_from_hand", ..
  double times_better = 0;  // ratio of the RMS disagreements
};

// A pose of the robot to take next.
struct AdvisedRobotPose {
  Pose base_from_hand;
  // Standard deviations of the camera's place in the mount, now and after it: largest of the three
  // directions, and axes.
  double sigma_now_m = 0, sigma_m = 0;
  double sigma_now_rad = 0, sigma_rad = 0;
  std::string sentence;
};

struct HandeyeEstimate {
  Status status = Status::degenerate;
  CameraMount mount = CameraMount::hand;
  // The answer. With rotation_axes_parallel the translations are one of many along an axis that a
  // finding names, with no_rotation the translations have no value; the rest holds. With other
  // refusals for diagnosis only.
  Pose mount_from_camera;
  Pose holder_from_board;
  // Of (omega rad, tau m) of the one and the other (`retract`), each 6 x 6, and jointly 12 x 12.
  // They include the robot's noise, which was estimated, and the covariance of the lens.
  Matrix6 camera_covariance = Matrix6::Zero();
  Matrix6 board_covariance = Matrix6::Zero();
  MatrixX covariance;
  // The board's lengths by the robot's, over those of its file, and the standard deviation. Places
  // are in the robot's lengths.
  double board_scale = 1;
  double sigma_board_scale = 0;
  // Standard deviations of the robot's poses, per axis, estimated from the views (restricted
  // maximum likelihood); and what is known of them, as a share of their value.
  double robot_sigma_m = 0;
  double robot_sigma_rad = 0;
  double robot_sigma_m_share = 0;
  double robot_sigma_rad_share = 0;
  // Degrees of freedom behind the robot's noise, for the camera's place. The covariances are
  // already wider for few of them.
  double degrees_of_freedom = 0;
  // Spread of the axes about which the camera turned from view to view: arc tangent of the second
  // over the first principal RMS rotation. 0: one axis. 45 degrees: two alike.
  double axis_spread_rad = 0;
  double rotation_rad = 0;  // RMS rotation from the views' mean, about the first principal axis
  // Where each view and its robot pose put the centre of the board in the holder: RMS distance from
  // their mean.
  double board_spread_m = 0;
  double rms_px = 0;  // with the estimated robot poses
  double sigma_px = 0;
  int num_corners = 0;
  std::vector<HandeyeViewFit> views;  // that take part
  std::vector<std::size_t> rejected;  // views whose robot pose contradicts the others, ascending
  std::vector<std::size_t> unusable;  // views without a pose of their own, ascending
  std::optional<RobotReading>
      reading;  // with wrong_direction and not_synchronous: proposed, not used
  // With a path: what is to be added to the views' times, and its standard deviation. Corrected
  // with HandeyeOptions::find_time_offset only.
  std::optional<double> time_offset_s;
  double sigma_time_offset_s = 0;
  std::optional<AdvisedRobotPose> next;
  std::vector<Finding> findings;
  double seconds = 0;
};

}  // namespace tagcal
