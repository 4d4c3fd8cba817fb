#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// The content of a calibration file; files of other programs (OpenCV) have the camera only.
struct CalibrationFile {
  Camera camera;
  std::string model;                         // "": not in the file
  std::map<std::string, double> fixed = {};  // lens parameters that were held
  std::vector<double> sigmas;                // of the lens parameters; empty: not in the file
  MatrixX covariance;                        // of the free parameters; empty: not in the file
  SeenRegion seen;                           // region of the corners; empty: not in the file
  // Error of a projection by this camera per coordinate, besides the noise of a corner: the error
  // of lens and target that the residuals show (all of the residuals if the corners had no
  // covariances) and the projection's uncertainty. No value if it is not in the file.
  std::optional<double> camera_error_px = std::nullopt;
};

// YAML that cv::FileStorage reads, with OpenCV's keys (image_width, image_height, camera_matrix,
// distortion_coefficients, avg_reprojection_error) and further ones (model, status, sigmas,
// covariance,
// ...). Precondition: calibration.camera has a value and is_answer(calibration.status).
std::string calibration_yaml(const Calibration& calibration);

// Throws Error, naming file, key and value. Reads both `model: fisheye4` and OpenCV's own files.
CalibrationFile read_calibration(const std::filesystem::path& file);

}  // namespace tagcal
