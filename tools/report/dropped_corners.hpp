#pragma once

#include <string>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// The corners that a calibration left out, for people: one line a view, whole views and whole tags
// as such, the corners of the others with their residuals; the worst views first, and no more than
// twenty lines.
std::string dropped_corners_text(const Calibration& calibration);

}  // namespace tagcal::tools
