#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/status.hpp"

namespace tagcal {

// A point of a target and the pixel at which it is seen.
struct Correspondence {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // target frame, metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct PoseOptions {
  double sigma_px = 0;  // noise per coordinate; 0: from the residuals where there are 50 degrees of
                        // freedom, else 0.5 px is assumed, and a warning says so
  int max_iterations = 50;
};

struct PoseHypothesis {
  Pose camera_from_target;
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m) in the camera frame: `retract`
  double rms_px = 0;                     // sqrt(sum |r|^2 / points)
  double probability = 1;                // by likelihood, among the hypotheses
};

struct PoseEstimate {
  Status status = Status::degenerate;
  std::vector<PoseHypothesis> hypotheses;  // best first; two where a plane fits two poses
  double sigma_px = 0;                     // what the covariance was computed with
  std::vector<std::string> warnings;

  // The likeliest pose. Precondition: is_answer(status).
  const Pose& camera_from_target() const { return hypotheses.front().camera_from_target; }
};

// The pose of a calibrated camera before a target, from four points or more (in a plane) or six or
// more (in space). Every point of an answer lies in the lens' domain, in front of the camera.
PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options = {});

}  // namespace tagcal
