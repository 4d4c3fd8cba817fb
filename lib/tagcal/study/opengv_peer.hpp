#pragma once

#include <vector>

#include "tagcal/study/pose_methods.hpp"

// OpenGV's poses (Kneip and Furgale, ICRA 2014), where it is installed. Private to study.

namespace tagcal {

// upnp, of its solutions the one of least residuals; the same, then optimize_nonlinear. None: there
// was no OpenGV when this was built.
std::vector<PoseMethod> opengv_poses();

}  // namespace tagcal
