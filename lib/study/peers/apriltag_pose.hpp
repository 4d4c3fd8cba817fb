#pragma once

#include "study/tasks/pose_task.hpp"

namespace tagcal::study {

// AprilTag's estimate_tag_pose, of squares whose corners are ordered as `square_points`. The
// homography, which its detector computes in any case, is made beforehand.
PoseMethod apriltag_pose();

}  // namespace tagcal::study
