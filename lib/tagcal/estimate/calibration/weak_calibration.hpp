#pragma once

#include <optional>

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// Maximum likelihood pose: the closed form of weak_perspective.hpp, then `minimise` with the
// corners' covariances. Of two equally good poses returns the one nearer to `perspective_pose`,
// which the remaining perspective selects. No value for fewer than four correspondences or without
// a finite fit.
std::optional<WeakView> fit_weak_view(const ViewProblem& view, const Eigen::Vector2d& centre,
                                      const Pose& perspective_pose);

// The fit of model weak: starts from calibration_seed, then solves and updates the inliers in turn
// until they are stable. No value if no view has a consensus.
std::optional<CalibrationFit> fit_weak(const CalibrationInput& input,
                                       const CalibrateOptions& options);

}  // namespace tagcal::internal
