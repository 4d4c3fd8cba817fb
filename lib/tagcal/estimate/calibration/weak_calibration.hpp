#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// One view under scaled orthographic projection: u = s (R X + t) + c, with its own scale s = f / Z
// and the centre c of the image.
struct WeakView {
  Pose camera_from_target;               // t_z is 0: depth is not in it
  std::optional<Pose> mirrored;          // of a plane: the other one, which fits as well
  double scale_px_per_m = 0;             // s
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, t_x m, t_y m, log s), sigma = 1; NaN
                                         // where a tilt is not determined
  double cost = 0;                       // sum of squared whitened residuals
};

// The likeliest view: the closed form of weak_perspective.hpp, then Levenberg-Marquardt for the
// corners' covariances. Of two poses that fit alike the one nearer to a perspective pose is given,
// with which what perspective there is goes. No value for fewer than four correspondences or where
// nothing fits.
std::optional<WeakView> fit_weak_view(const ViewProblem& view, const Eigen::Vector2d& centre,
                                      const Pose& near);

// Every view by itself, on the corners that agree with it.
struct WeakFit {
  CalibrationFit fit;  // of model weak; poses are those of the views
  std::vector<WeakView> views;
};

// Starts from consensus, leaves out what is further than kRejectSigmas from the answer, takes back
// what is nearer, until nothing moves. No value where no view has a consensus.
std::optional<WeakFit> fit_weak(const CalibrationInput& input, const CalibrateOptions& options);

}  // namespace tagcal::internal
