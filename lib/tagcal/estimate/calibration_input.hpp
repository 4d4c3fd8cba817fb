#pragma once

#include <string>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/start.hpp"

namespace tagcal {

// A data set as the solvers see it. Views that cannot fix a pose (fewer than four corners, or all
// on a line), mirrored ones and repeats are left out, and said in the warnings.
struct CalibrationInput {
  ImageSize image_size;
  std::vector<CalibrationView> views;
  bool whitened = false;  // every corner has its covariance, and residuals are whitened by it
  std::vector<std::string> warnings;
  std::vector<Outlier> dropped;  // corners of views that were taken out as wrong
};
// `sigma_stated`: one noise for all corners; their own covariances do not count.
CalibrationInput calibration_input(const Dataset& dataset, bool sigma_stated);

}  // namespace tagcal
