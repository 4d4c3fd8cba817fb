#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// One parameter compared with the truth.
struct ParameterError {
  std::string name;
  double estimate = 0;
  double truth = 0;
  std::optional<double> sigma;      // 0: held; none: not known
  std::optional<double> in_sigmas;  // (estimate - truth) / sigma, if sigma is above 0
};

struct Validation {
  // Our projection against cv::projectPoints or cv::fisheye::projectPoints, over all observations.
  double max_projection_difference_px = 0;
  double max_jacobian_difference = 0;  // relative to the largest entry of the column
  int num_compared = 0;
  int num_outside_domain = 0;  // counted, not compared
  double rms_px = 0;           // of the observations, poses estimated here with the given camera
  int num_views = 0;           // with a pose
  int num_without_pose = 0;    // views without a pose
  double bound_px = 0;         // 1e-9 for the pinhole family, 1e-8 for fisheye
  bool opencv_agrees = false;  // all differences are within their bounds, and there are some
  std::vector<ParameterError> parameters;  // if the truth is known and has the same type of lens
  // The number of parameters whose error exceeds kTruthBound standard deviations; no value if none
  // has a standard deviation.
  std::optional<int> num_beyond_truth;
  std::vector<std::string> warnings;
};

// In standard deviations: by chance once in 1.7 million parameters.
inline constexpr double kTruthBound = 5;

// Compares a camera (with the standard deviations of its parameters, or none) with OpenCV and, if
// the data set has it, with the truth. The pose of each view is estimated as by `tagcal pose`.
// `camera_error_px` is the error in the camera's file (CalibrationFile); the covariances of the
// corners are used only if it is given.
Validation validate(const Camera& camera, const std::vector<double>& sigmas, const Dataset& dataset,
                    const std::optional<double>& camera_error_px = std::nullopt);

// The six numbers of a camera's place in a rig against the truth, relative to a reference camera:
// `name` is rotation x, y, z (rad; `minus`) and translation x, y, z (m).
std::vector<ParameterError> validate_place(const KnownRig& rig, const RigTruth& truth,
                                           std::size_t camera, std::size_t reference);

}  // namespace tagcal
