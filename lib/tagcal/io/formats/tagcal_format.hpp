#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// tagcal's own calibration file: OpenCV's keys and further ones. Parts of it, which
// calibration_yaml writes with the results of an estimate, and a whole file without them.

namespace tagcal::internal {

// image_width, image_height, camera_matrix, distortion_coefficients. Without a focal length there
// is no camera matrix that another program could read.
std::string camera_yaml(const Camera& camera, std::string_view model);

// fixed, parameter_names, sigmas, covariance_names, covariance: as far as known.
std::string uncertainty_yaml(const CalibrationFile& calibration);

std::string seen_yaml(const SeenRegion& seen);
std::string pose_lines(const Pose& pose, std::string_view prefix);

FormatOutput write_tagcal(const CameraFile& file);

}  // namespace tagcal::internal
