#pragma once

#include "tagcal/estimate/checks/evidence.hpp"

namespace tagcal::internal {

// Returns the answer of a solution: status, uncertainty, findings. Under model weak every view has
// its own scale, and the lens only the centre of the image.
Calibration report(const Solution& solution, Evidence evidence);

}  // namespace tagcal::internal
