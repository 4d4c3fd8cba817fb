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
  std::vector<ParameterError> parameters;  // where the truth is known
  double bound_px = 0;                     // 1e-9 for the pinhole family, 1e-8 for fisheye
  bool passed = false;  // all differences within their bounds, and something compared
  std::vector<std::string> warnings;
};

// Holds a camera (with the standard deviations of its parameters, or none) against OpenCV and,
// where the data set knows it, against the truth.
Validation validate(const Camera& camera, const std::vector<double>& sigmas,
                    const Dataset& dataset);

}  // namespace tagcal
