#pragma once

#include <vector>

#include "study/tasks/pose_task.hpp"

// OpenGV's poses (Kneip and Furgale, ICRA 2014), if it is installed. Private to study.

namespace tagcal::study {

// Two methods: the solution of upnp with the least residuals, and the same refined by
// optimize_nonlinear. Empty if the build did not find OpenGV.
std::vector<PoseMethod> opengv_poses();

}  // namespace tagcal::study
