#pragma once

#include "tagcal/estimate/calibration/board_warp.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"
#include "tagcal/estimate/calibration/weak_calibration.hpp"

namespace tagcal::internal {

// What a fit says: status, uncertainty, warnings. `board` may be null; with options.board_warp the
// bend's increment stands in the result. `supported`: models that count in what is claimed.
Calibration report(const CalibrationFit& fit, const CalibrateOptions& options,
                   const FlatBoard* board, std::span<const SupportedModel> supported = {});

// Sets sigma_px by the rule: stated, else from the residuals where these are enough to show it; and
// warns where they contradict it.
void choose_sigma(Calibration& c, const CalibrationFit& fit, const CalibrateOptions& options);

// Every view with its own scale; the lens holds nothing but the centre of the image. Ok unless half
// of the corners were rejected or too few are left.
Calibration report_weak(const WeakFit& weak, const CalibrateOptions& options);

}  // namespace tagcal::internal
