#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"

namespace tagcal::internal {

// Standard deviation t per coordinate (px) of the noise in the residuals r beyond the covariances C
// of their corners: the sum of r' (C + t^2 I)^-1 r equals its degrees of freedom (Paule & Mandel
// 1982). 0 if the covariances explain the residuals.
double excess_px(std::span<const Eigen::Vector2d> residuals_px,
                 std::span<const Matrix2> covariance_px2, double degrees_of_freedom);

// The covariance of a corner that is whitened so.
Matrix2 covariance_of(const Matrix2& whitening);

// Estimates the error of lens and target (excess_px) from a fit, and adds it to the covariance of
// every corner of a whitened input. Returns true if it changed, so that the fit must be repeated.
bool update_model_error(CalibrationInput& input, const CalibrationFit& fit);

}  // namespace tagcal::internal
