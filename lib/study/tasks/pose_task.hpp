#pragma once

#include <optional>
#include <vector>

#include "study/method.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::study {

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

}  // namespace tagcal::study
