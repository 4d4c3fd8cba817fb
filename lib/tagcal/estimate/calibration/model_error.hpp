#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"

namespace tagcal::internal {

// What residuals hold beyond the covariances C of their corners, as a standard deviation t per
// coordinate (px): that for which the sum of r' (C + t^2 I)^-1 r is its degrees of freedom (Paule &
// Mandel 1982). 0 where the noise alone explains them.
double excess_px(std::span<const Eigen::Vector2d> residuals_px,
                 std::span<const Matrix2> covariance_px2, double degrees_of_freedom);

// Corners whose own noise is known to a hundredth of a pixel show what no lens and no printed
// target is free of. Where a fit's residuals say so, every corner of the input gets that much more
// noise; true where it changed, so that the fit is worth repeating. Nothing happens to an input
// that is not whitened.
bool count_model_error(CalibrationInput& input, const CalibrationFit& fit);

}  // namespace tagcal::internal
