#pragma once

#include "study/tasks/pose_task.hpp"

namespace tagcal::study {

// AprilTag's estimate_tag_pose for squares with corners in the order of `square_points`. The
// homography is not timed, because the detector computes it anyway.
PoseMethod apriltag_pose();

}  // namespace tagcal::study
