#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "tagcal/estimate/types.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal {

// YAML that cv::FileStorage reads, with OpenCV's keys (image_width, image_height, camera_matrix,
// distortion_coefficients, avg_reprojection_error) and further ones (model, status, sigmas,
// covariance, claim_covariance, ...). Precondition: calibration.camera has a value and
// is_answer(calibration.status).
std::string calibration_yaml(const Calibration& calibration);

// What that file says of the camera. The same precondition.
CalibrationFile calibration_file(const Calibration& calibration);

// Reads the camera of a file of tagcal or of another program, as usable_camera(read_one_camera(..))
// of camera_file.hpp does: "FILE" or "FILE:NAME". Throws Error, naming file, key and value.
CalibrationFile read_calibration(const std::filesystem::path& file);

// A text as YAML, in double quotes, for the files that a program writes beside.
std::string quoted_yaml(std::string_view text);

}  // namespace tagcal
