#pragma once

#include <vector>

#include "study/tasks/pose_task.hpp"

namespace tagcal::study {

// The kinds of problems; they have different methods.
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

// Our estimators first, then our closed forms and minimal solvers, then those of OpenCV and
// AprilTag. Each is called as its documentation advises: double precision, no distortion, one
// thread (the caller's).
std::vector<PoseMethod> pose_methods(PoseJob job);

}  // namespace tagcal::study
