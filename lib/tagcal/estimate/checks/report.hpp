#pragma once

#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"
#include "tagcal/estimate/calibration/weak_calibration.hpp"

namespace tagcal::internal {

// Returns the answer of a fit: status, uncertainty, findings. `board` may be null; with
// options.board_warp the result holds the bend. `supported`: other models whose
// weighted differences are part of the standard deviations.
Calibration report(const CalibrationFit& fit, const CalibrateOptions& options,
                   const FlatBoard* board, std::span<const SupportedModel> supported = {});

// Sets sigma_px: the stated noise, else the one of the residuals if there are enough of them. Warns
// if the residuals contradict the stated noise.
void choose_sigma(Calibration& c, const CalibrationFit& fit, const CalibrateOptions& options);

// Returns the answer of model weak: every view has its own scale, and the lens only the centre of
// the image. The status is ok unless half of the corners were rejected or too few are left.
Calibration report_weak(const WeakFit& weak, const CalibrateOptions& options);

}  // namespace tagcal::internal
