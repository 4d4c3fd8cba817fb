#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/pose.hpp"
#include "tagcal/study/method.hpp"

namespace tagcal {

// One view with its truth, as studies make it.
struct PoseTask {
  std::vector<Correspondence> correspondences;
  std::vector<int> groups;  // a tag's id of each, or empty
  Camera camera;            // a pinhole; pose with focal length does not use its focal length
  double sigma_px = 0;
  Pose camera_from_target;
};

// What a method says. Only ours fill the lower half.
struct PoseAnswer {
  bool success = false;
  Pose camera_from_target;
  double focal_px = 0;  // of pose with focal length

  std::optional<Matrix6> covariance;
  std::optional<Matrix7> covariance_with_focal;
  std::optional<Status> status;
  struct Alternative {
    Pose camera_from_target;
    Matrix6 covariance;
  };
  std::vector<Alternative> alternatives;  // the other poses that it names
};

using PreparedPose = Prepared<PoseAnswer>;
using PoseMethod = Method<PoseTask, PoseAnswer>;

// What is to be solved, for which methods differ.
enum class PoseJob {
  tag,               // four corners of a square about its centre
  plane,             // many points in a plane
  space,             // many points in space
  four_space,        // four points in space
  outliers,          // some of them wrong
  plane_focal,       // pose and focal length, in a plane
  four_space_focal,  // pose and focal length, four points in space
  space_focal,       // many points in space
};

// Ours first, then the closed forms and minimal solvers of ours, then OpenCV's and AprilTag's, each
// as its documentation advises: double precision, no distortion, one thread (the caller's).
std::vector<PoseMethod> pose_methods(PoseJob job);

}  // namespace tagcal
