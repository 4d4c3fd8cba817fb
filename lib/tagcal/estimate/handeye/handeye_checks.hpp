#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "tagcal/estimate/handeye/handeye_bundle.hpp"

namespace tagcal::internal {

// Throw Error for input that is refused; `name` is that of a view.
void check_path(const RobotPath& path);
void check_seen_pose(const SeenPose& pose, Eigen::Index num_shared, const std::string& name);

// The rotations of the camera from view to view, about the mean of their poses.
struct AxisSpread {
  Eigen::Vector3d rms_rad = Eigen::Vector3d::Zero();        // principal ones, the largest first
  Eigen::Matrix3d in_camera = Eigen::Matrix3d::Identity();  // their axes, by column

  double spread_rad() const;  // HandeyeEstimate::axis_spread_rad
};
AxisSpread axis_spread(std::span<const Pose> camera_from_board);

// What chance and few degrees of freedom do to a covariance: the factor by which its 95 % region of
// six parameters, by chi-square, becomes that of Fisher's F.
double widening(double degrees_of_freedom);

// Adds what refuses the answer: places that the views do not determine.
void check_determined(const AxisSpread& axes, const HandeyeScale& scale, HandeyeEstimate& answer);

// The standard deviation of the logarithm of the board's scale, wider for few degrees of freedom.
double sigma_of_log_scale(const HandeyeMinimum& minimum);
// Does the scale of a bundle in which it is free contradict its prior, of this standard deviation?
bool is_beyond_prior(const HandeyeMinimum& minimum, double prior_sigma);
// Says that lengths of robot and board differ.
void add_board_scale(HandeyeEstimate& answer);

}  // namespace tagcal::internal
