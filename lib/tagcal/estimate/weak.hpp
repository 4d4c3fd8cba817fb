#pragma once

#include <optional>

#include "tagcal/estimate/reprojection.hpp"

namespace tagcal {

// One view under scaled orthographic projection: u = s (R X + t) + c, with its own scale s = f / Z
// and the centre c of the image.
struct WeakView {
  Pose camera_from_target;               // t_z is 0: depth is not in it
  double scale_px_per_m = 0;             // s
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, t_x m, t_y m, log s), sigma = 1; NaN
                                         // where a tilt is not determined
  double cost = 0;                       // sum of squared whitened residuals
};

// The likeliest view near a perspective pose, by Levenberg-Marquardt; no value for fewer than four
// correspondences or where nothing fits. (A plane seen this way has a second pose, mirrored in the
// image plane, that fits as well: this is the one near the start.)
std::optional<WeakView> fit_weak_view(const ViewProblem& view, const Eigen::Vector2d& centre,
                                      const Pose& near);

}  // namespace tagcal
