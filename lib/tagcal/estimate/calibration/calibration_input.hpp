#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// A data set as the solvers see it. Views that cannot fix a pose (fewer than four corners, or all
// on a line), mirrored ones and repeats are left out, and said in the warnings.
struct CalibrationInput {
  ImageSize image_size;
  std::shared_ptr<const HeldModels> models;  // that are fitted
  std::vector<CalibrationView> views;
  bool whitened = false;      // residuals are whitened by the corners' own covariances,
  double model_error_px = 0;  // with so much more noise per coordinate
  std::vector<std::string> warnings;
  std::vector<Outlier> dropped;  // corners of views that were taken out as wrong
};
// The corners' own covariances count where half of them and more have one (0.5 px of noise is
// assumed for the rest) and no noise for all of them is stated. Mirrored views stay where nothing
// is to be rejected.
CalibrationInput calibration_input(const Dataset& dataset, const CalibrateOptions& options);

}  // namespace tagcal::internal
