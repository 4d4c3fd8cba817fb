#pragma once

#include "study/tasks/pose_task.hpp"

// The error of an answer, and the Cramer-Rao bound of the error.

namespace tagcal::study {

// The errors of pose with focal length are measured in (omega, u, v, log(Z / f), log f), (u, v) the
// pixel of the target's centre: focal length and distance are correlated, and along that ridge of
// the likelihood the translation is far from linear, while these variables are nearly normal. The
// matrix converts steps (omega, tau, log f) to them.
Matrix7 along_the_ridge(const Pose& camera_from_target, double focal_px);

using Vector7d = Eigen::Matrix<double, 7, 1>;
Vector6d pose_error(const PoseAnswer& answer, const PoseTask& task);  // steps of `retract`
Vector7d pose_and_focal_error(const PoseAnswer& answer, const PoseTask& task);

// The information about these errors at the truth; its inverse bounds the covariance of every
// unbiased estimate. Precondition: task.sigma_px > 0.
Matrix6 pose_information(const PoseTask& task);
Matrix7 pose_and_focal_information(const PoseTask& task);

// The second pose of a plane (z to the viewer): mirrored across the line of sight.
Pose flipped(const Pose& camera_from_plane);

// Returns true if a pose is nearer to the flipped truth than to the truth.
bool is_flip(const Pose& pose, const Pose& truth);

}  // namespace tagcal::study
