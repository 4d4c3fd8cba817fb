#pragma once

#include <string>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// Text about the rejected corners: one line per view, with whole views and whole tags summed up and
// single corners with their residuals. The worst views come first; at most twenty lines.
std::string dropped_corners_text(const Calibration& calibration, bool verbose);

}  // namespace tagcal::tools
