#pragma once

#include <span>
#include <string>

#include "tagcal/estimate/handeye.hpp"

namespace tagcal::tools {

// Returns the report for a person: the verdict, findings, the places of camera and board, the
// robot's noise, the spread of the axes, the worst views, and the next pose.
std::string handeye_summary(const HandeyeEstimate& handeye, std::span<const HandeyeView> views);

// Returns one JSON object (docs/reference/formats.md).
std::string handeye_json(const HandeyeEstimate& handeye, std::span<const HandeyeView> views);

}  // namespace tagcal::tools
