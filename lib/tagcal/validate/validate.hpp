#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// One parameter held against the truth.
struct ParameterError {
  std::string name;
  double estimate = 0;
  double truth = 0;
  double sigma = 0;      // 0: held
  double in_sigmas = 0;  // (estimate - truth) / sigma; 0 for a held parameter that is right
};

struct Validation {
  // Our projection against cv::projectPoints or cv::fisheye::projectPoints, over all observations.
  double max_projection_difference_px = 0;
  double max_jacobian_difference = 0;  // relative to the largest entry of the column
  int num_compared = 0;
  int num_outside_domain = 0;  // counted, not compared
  double rms_px = 0;           // of the observations, poses estimated here with the given camera
  int num_views = 0;           // with a pose
  int num_without_pose = 0;    // views
  double bound_px = 0;         // 1e-9 for the pinhole family, 1e-8 for fisheye
  bool opencv_agrees = false;  // all differences within their bounds, and something compared
  std::vector<ParameterError> parameters;  // where the truth is known and of the same kind of lens
  // Of those that have a standard deviation, how many are more than kTruthBound of them off the
  // truth; none where no parameter can be judged so.
  std::optional<int> num_beyond_truth;
  std::vector<std::string> warnings;
};

// In standard deviations: by chance once in 1.7 million parameters.
inline constexpr double kTruthBound = 5;

// Holds a camera (with the standard deviations of its parameters, or none) against OpenCV and,
// where the data set knows it, against the truth. Each view's pose is estimated as `tagcal pose`
// does: `camera_error_px` is what the camera's file says of its error (CalibrationFile), so that
// the corners' own covariances count; without it they do not.
Validation validate(const Camera& camera, const std::vector<double>& sigmas, const Dataset& dataset,
                    const std::optional<double>& camera_error_px = std::nullopt);

}  // namespace tagcal
