#pragma once

#include <string>

#include "tagcal/estimate/rig_types.hpp"

namespace tagcal {

// rig.yaml (docs/reference/formats.md): the cameras as in calibration files, with camera_from_rig
// and its covariance, the joint covariance, and findings. read_camera_file reads the cameras and
// their places. Precondition: is_answer(rig.status).
std::string rig_yaml(const RigCalibration& rig);

}  // namespace tagcal
