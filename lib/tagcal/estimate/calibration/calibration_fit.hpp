#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/calibration_input.hpp"
#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// The floor of the standard deviation of a (whitened) coordinate.
inline double least_sigma(bool whitened, const CalibrateOptions& options) {
  return whitened ? 1 : std::max(policy::kLeastSigmaPx, options.sigma_px);
}

// The inliers, the pose of each view (none: the view is not used), and its row terms.
struct Selection {
  std::vector<std::optional<Pose>> pose;
  std::vector<std::vector<std::uint8_t>> inlier;
  std::vector<Vector6d> row_terms;
  std::vector<double> scale_px_per_m;  // of model weak; else empty

  std::ptrdiff_t num_inliers(std::size_t view) const;
  bool uses(std::size_t view) const;
};

// One view under scaled orthographic projection: u = s (R X + t) + c, with its own scale s = f / Z
// and the centre c of the image.
struct WeakView {
  Pose camera_from_target;               // t_z is 0: the depth is not determined
  std::optional<Pose> mirrored;          // of a plane: the second pose, which fits as well
  double scale_px_per_m = 0;             // s
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, t_x m, t_y m, log s), sigma = 1; NaN
                                         // if the tilt is not determined
  double cost = 0;                       // sum of squared whitened residuals
};

// One model, solved on its inliers.
struct CalibrationFit {
  Bundle bundle;                  // inliers only
  std::vector<std::size_t> used;  // per view of the bundle: its index in the input
  Selection selection;            // of the input's views
  // Squared whitened residuals of all corners of the input's views; infinite outside the domain.
  std::vector<std::vector<double>> squares;
  bool whitened = false;
  BundleSummary summary;
  int num_corners = 0;  // inliers and outliers
  int num_iterations = 0;
  double more_cost = 0;  // of the inliers, above that of the fit that `squares` belong to
  std::vector<Finding> findings;
  double start_seconds = 0;
  double solve_seconds = 0;
  std::vector<WeakView> weak;  // of model weak, per view of the bundle; else empty

  bool has_perspective() const { return weak.empty(); }
  // The lens of a view of the input: the bundle's, with the view's scale for model weak.
  Lens lens(std::size_t view) const;
  int num_inliers() const;
  // Sum over all corners of min(square / sigma^2, policy::kOutlierSigmas^2).
  double truncated_chi_square(double sigma) const;
};

// The selection of a start. It has all corners if options.reject_outliers is false.
Selection selection_of(const CalibrationSeed& seed, const CalibrateOptions& options);

// Inliers and the solution to them.
struct RobustState {
  Selection selection;
  std::vector<std::vector<double>> squares;  // squared whitened residuals of all corners, per view
  double noise = 0;                          // robust, of the inliers' coordinates
  double sigma = 0;                          // the same, at least least_sigma: of rejection
};

// Solves and takes the corners within policy::kOutlierSigmas as inliers, in turn until they and
// their noise are stable. `solve` sets the poses and squares of the state; it returns false if no
// view is left.
void update_until_stable(RobustState& state, bool whitened, const CalibrateOptions& options,
                         const std::function<bool()>& solve);

// Takes over the selection of a state, and adds a finding for each view that is not in fit.used.
void take_selection(const CalibrationInput& input, RobustState state, CalibrationFit& fit);

// The corners that a fit does not use, with their residuals.
std::vector<Outlier> outliers_of(const CalibrationInput& input, const CalibrationFit& fit);

// Finds a start, then solves and updates the inliers in turn until they are stable: first without
// row terms, then with those that the views show. Views that lost corners, or all of them, get
// another pose under the lens that was found, and all corners are tried again. No value if no view
// has a consensus.
std::optional<CalibrationFit> fit_model(const Model& model, const CalibrationInput& input,
                                        const CalibrateOptions& options);

// The same bundle with another model, whose lens is the nearest to the solved one, solved on the
// same inliers, with the same row terms' prior. `free_values`: where it starts.
CalibrationFit fit_on_inliers(CalibrationFit fit, const Model& model,
                              std::vector<double> free_values, const CalibrateOptions& options);

}  // namespace tagcal::internal
