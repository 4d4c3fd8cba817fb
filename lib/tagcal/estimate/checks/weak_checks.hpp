#pragma once

#include <optional>

#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/findings.hpp"

// Checks of model weak.

namespace tagcal::internal {

// Fewer corners than parameters.
std::optional<Finding> check_corner_count(const CalibrationFit& fit);
// The board faces the camera in some views.
std::optional<Finding> check_tilts(const Calibration& answer);
// The residuals of most views are spatially correlated, which perspective causes and this model
// does not have.
std::optional<Finding> check_perspective(const CalibrationFit& fit);

}  // namespace tagcal::internal
