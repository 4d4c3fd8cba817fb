#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// A data set as the solvers see it. Findings name the views that are not used: those whose corners
// do not determine a pose (fewer than four of one board, or all on a line), mirrored ones and
// repeated ones.
struct CalibrationInput {
  ImageSize image_size;
  std::shared_ptr<const HeldModels> models;  // with the fixed parameters held
  std::vector<CalibrationView> views;        // of a flat board
  std::optional<FlatBoard> board;            // whose shape is estimated; none: several, or no plane
  bool whitened = false;         // residuals are whitened by the corners' own covariances
  double model_error_px = 0;     // and by this noise per coordinate, added to them
  std::optional<bool> has_rows;  // views have row terms, by the best lens of all, if it is known
  std::vector<Finding> findings;
  std::vector<Outlier> rejected;  // corners of whole views and boards that were rejected
};

// Uses the corners' own covariances if at least half of the corners have one and no common noise is
// stated; the others get policy::kAssumedSigmaPx. Keeps mirrored views if options.reject_outliers
// is false.
CalibrationInput calibration_input(const Dataset& dataset, const CalibrateOptions& options);

// The model is chosen, not given by its name.
bool is_auto(const CalibrateOptions& options);

// All models with the parameters held that the options fix.
std::shared_ptr<const HeldModels> models_of(const CalibrateOptions& options);

SeedOptions seed_options(const CalibrateOptions& options);

// Throws Error for a start or for fixed parameters that no data set can be calibrated with.
void check_lens_options(const CalibrateOptions& options);

}  // namespace tagcal::internal
