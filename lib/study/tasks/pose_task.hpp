#pragma once

#include <optional>
#include <vector>

#include "study/method.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::study {

// One view with its truth.
struct PoseTask {
  std::vector<Correspondence> correspondences;
  std::vector<int> groups;  // the tag's id of each correspondence, or empty
  Camera camera;            // a pinhole; pose with focal length does not use its focal length
  double sigma_px = 0;
  Pose camera_from_target;
};

// The answer of a method. Only our methods set the members from `covariance` on.
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
  std::vector<Alternative> alternatives;  // other poses that fit as well
};

using PreparedPose = Prepared<PoseAnswer>;
using PoseMethod = Method<PoseTask, PoseAnswer>;

}  // namespace tagcal::study
