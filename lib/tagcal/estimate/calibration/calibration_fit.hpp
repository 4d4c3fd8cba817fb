#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/calibration_input.hpp"
#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// The floor of the standard deviation of a (whitened) coordinate.
inline double least_sigma(bool whitened, const CalibrateOptions& options) {
  return whitened ? 1 : std::max(policy::kLeastSigmaPx, options.sigma_px);
}

// One model, solved on its inliers.
struct CalibrationFit {
  Bundle bundle;                    // inliers only
  std::vector<std::size_t> views;   // per view of the bundle: its index in the data set
  std::vector<std::string> images;  // and its name
  bool whitened = false;
  BundleSummary summary;
  int num_corners = 0;  // inliers and outliers
  int num_iterations = 0;
  std::vector<double> squares;  // squared whitened residual per corner; infinite outside the domain
  std::vector<Outlier> outliers;
  std::vector<Finding> findings;
  double bic = 0;
  double start_seconds = 0;
  double solve_seconds = 0;

  int num_inliers() const;
  // Sum over all corners of min(square / sigma^2, policy::kOutlierSigmas^2).
  double truncated_chi_square(double sigma) const;
};

// The inliers, and the pose of each view (none: the view is not used).
struct Selection {
  std::vector<std::optional<Pose>> pose;
  std::vector<std::vector<std::uint8_t>> inlier;

  std::ptrdiff_t num_inliers(std::size_t view) const;
  bool uses(std::size_t view) const;
};

// The selection of a start. It has all corners if options.reject_outliers is false.
Selection selection_of(const CalibrationSeed& seed, const CalibrateOptions& options);

// Inliers and the solution to them.
struct RobustState {
  Selection selection;
  std::vector<std::vector<double>> squares;  // squared whitened residuals of all corners, per view
  double sigma = 0;                          // robust, of the inliers' coordinates
};

// Solves and takes the corners within policy::kOutlierSigmas as inliers, in turn until they are
// stable. `solve` sets the poses and squares of the state; it returns false if no view is left.
void update_until_stable(RobustState& state, bool whitened, const CalibrateOptions& options,
                         const std::function<bool()>& solve);

// Lists in `fit` the corners and views that it does not use. `lens`: of a view.
void list_outliers(const CalibrationInput& input, const RobustState& state,
                   const std::function<Lens(std::size_t)>& lens, CalibrationFit& fit);

// Finds a start, then solves and updates the inliers in turn until they are stable; and the same
// once more from all corners, kept if its truncated chi-square is lower. No value if no view has a
// consensus.
std::optional<CalibrationFit> fit_model(const Model& model, const CalibrationInput& input,
                                        const CalibrateOptions& options);

// The same from a solved bundle, with the views and inliers of another fit as the start. The times
// stay zero.
std::optional<CalibrationFit> refit(const Bundle& solved, const CalibrationFit& other,
                                    const CalibrationInput& input, const CalibrateOptions& options);

}  // namespace tagcal::internal
