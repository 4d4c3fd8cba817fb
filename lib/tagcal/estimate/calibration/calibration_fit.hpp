#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/calibration_input.hpp"
#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// Corners further than this many standard deviations from the answer are rejected.
inline constexpr double kRejectSigmas = 5;

// The least standard deviation that this may be: below 0.01 px digits in a file decide, not noise.
inline double least_sigma(bool whitened, const CalibrateOptions& options) {
  return whitened ? 1 : std::max(0.01, options.sigma_px);
}

// One model, solved on the corners that agree with it.
struct CalibrationFit {
  Bundle bundle;                    // inliers only
  std::vector<std::size_t> views;   // of the data set, by number, per view of the bundle
  std::vector<std::string> images;  // their names
  bool whitened = false;
  BundleSummary summary;
  int num_corners = 0;  // inliers and outliers
  int num_iterations = 0;
  std::vector<double> squares;  // of every corner's whitened residual, infinite where it has none
  std::vector<Outlier> outliers;
  std::vector<std::string> warnings;
  double bic = 0;
  double start_seconds = 0;
  double solve_seconds = 0;

  int num_inliers() const;
  // Squared residuals of all corners in units of a noise, each up to the rejection bound.
  double truncated_misfit(double sigma) const;
};

// Starts, solves, leaves out what is further than five standard deviations from the answer, takes
// back what is nearer, and solves again until nothing moves. Then what is out by up to ten
// or forty, and all that is out, is fitted with the others, and that is the answer where it
// explains all corners better, each counting up to the bound of rejection. No value where no view
// has a consensus.
std::optional<CalibrationFit> fit_model(const Model& model, const CalibrationInput& input,
                                        const CalibrateOptions& options);

// The same from a solved bundle on the inliers of another fit: its views and corners are the
// start. Times are left to the caller.
std::optional<CalibrationFit> refit(const Bundle& solved, const CalibrationFit& other,
                                    const CalibrationInput& input, const CalibrateOptions& options);

}  // namespace tagcal::internal
