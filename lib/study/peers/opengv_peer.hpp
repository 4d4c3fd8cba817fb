#pragma once

#include <vector>

#include "study/tasks/pose_task.hpp"

// OpenGV's poses (Kneip and Furgale, ICRA 2014), where it is installed. Private to study.

namespace tagcal::study {

// upnp, of its solutions the one of least residuals; the same, then optimize_nonlinear. None: there
// was no OpenGV when this was built.
std::vector<PoseMethod> opengv_poses();

}  // namespace tagcal::study
