#pragma once

#include "study/tasks/pose_task.hpp"

// How far an answer is from the truth of its task, and how far it has to be: the Cramer-Rao bound.

namespace tagcal::study {

// The errors of pose with focal length are taken in (omega, u, v, log(Z / f), log f), (u, v) the
// pixel of the target's centre: focal length and distance hang together, and along that ridge of
// the likelihood the translation is far from linear, while these are nearly normal. The matrix
// leads to them from steps (omega, tau, log f).
Matrix7 along_the_ridge(const Pose& camera_from_target, double focal_px);

using Vector7d = Eigen::Matrix<double, 7, 1>;
Vector6d pose_error(const PoseAnswer& answer, const PoseTask& task);  // steps of `retract`
Vector7d pose_and_focal_error(const PoseAnswer& answer, const PoseTask& task);

// The information at the truth, of the errors above: its inverse bounds the covariance of every
// unbiased estimate. Precondition: task.sigma_px > 0.
Matrix6 pose_information(const PoseTask& task);
Matrix7 pose_and_focal_information(const PoseTask& task);

// The pose that a plane's (z to the viewer) is mistaken for: mirrored across the line of sight.
Pose flipped(const Pose& camera_from_plane);

// Whether a pose is nearer to the flipped truth than to the truth.
bool is_flip(const Pose& pose, const Pose& truth);

}  // namespace tagcal::study
