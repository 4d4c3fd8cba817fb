#pragma once

#include <vector>

#include "study/tasks/pose_task.hpp"

namespace tagcal::study {

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

}  // namespace tagcal::study
