#pragma once

#include <string>

#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal {

// rig.yaml (docs/reference/formats.md): the cameras as in calibration files, with camera_from_rig
// and its covariance, the joint covariance, and findings. read_camera_file reads the cameras and
// their places. Precondition: is_answer(rig.status).
std::string rig_yaml(const RigCalibration& rig);

// The same as read_camera_file reads it. Precondition: is_answer(rig.status).
CameraFile camera_file(const RigCalibration& rig);

// The rig of a file that was read, for use by tagcal. Throws Error, naming the file, if a camera
// has no place or cannot be used (usable_camera).
KnownRig known_rig(const CameraFile& file, const std::string& name);

}  // namespace tagcal
