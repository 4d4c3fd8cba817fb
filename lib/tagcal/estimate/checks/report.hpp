#pragma once

#include "tagcal/estimate/calibration/weak_calibration.hpp"
#include "tagcal/estimate/checks/evidence.hpp"

namespace tagcal::internal {

// Returns the answer of a solution: status, uncertainty, findings.
Calibration report(const Solution& solution, Evidence evidence);

// Returns the answer of model weak: every view has its own scale, and the lens only the centre of
// the image. `refusal`: of a model with perspective, or none.
Calibration report_weak(const WeakFit& weak, const CalibrationInput& input,
                        const CalibrateOptions& options, std::optional<Finding> refusal = {});

}  // namespace tagcal::internal
