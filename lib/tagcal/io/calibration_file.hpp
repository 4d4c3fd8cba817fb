#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// What a calibration file says of its camera; of others' files (OpenCV's own samples), the camera.
struct CalibrationFile {
  Camera camera;
  std::string model;                         // "" where the file does not say
  std::map<std::string, double> fixed = {};  // lens parameters that were held as asked
  std::vector<double> sigmas;  // of the lens parameters, empty where the file does not say
  MatrixX covariance;          // of the free parameters, empty where the file does not say
  SeenRegion seen;             // where the corners were, empty where the file does not say
  // What a projection by this camera is wrong by, per coordinate, besides the noise of a corner:
  // the error of lens and target that the residuals showed (all of the residuals, where corners had
  // no covariances of their own) and the projection's uncertainty. None where the file does not
  // say.
  std::optional<double> camera_error_px = std::nullopt;
};

// YAML that cv::FileStorage reads, with OpenCV's keys (image_width, image_height, camera_matrix,
// distortion_coefficients, avg_reprojection_error) and ours (model, status, sigmas, covariance,
// ...). Precondition: calibration.camera has a value and is_answer(calibration.status).
std::string calibration_yaml(const Calibration& calibration);

// Throws Error, naming file, key and value. Reads both `model: fisheye4` and OpenCV's own files.
CalibrationFile read_calibration(const std::filesystem::path& file);

}  // namespace tagcal
