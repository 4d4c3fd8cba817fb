#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

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

// Maximum likelihood pose: the closed form of weak_perspective.hpp, then Levenberg-Marquardt with
// the corners' covariances. Of two equally good poses returns the one nearer to `perspective_pose`,
// which the remaining perspective selects. No value for fewer than four correspondences or without
// a finite fit.
std::optional<WeakView> fit_weak_view(const ViewProblem& view, const Eigen::Vector2d& centre,
                                      const Pose& perspective_pose);

// All views, each solved by itself on its inliers.
struct WeakFit {
  CalibrationFit fit;  // of model weak, with the poses of the views
  std::vector<WeakView> views;
  std::vector<Outlier> outliers;
};

// Starts from calibration_seed, then solves and updates the inliers in turn until they are stable.
// No value if no view has a consensus.
std::optional<WeakFit> fit_weak(const CalibrationInput& input, const CalibrateOptions& options);

}  // namespace tagcal::internal
