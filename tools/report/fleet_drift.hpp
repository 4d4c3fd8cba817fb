#pragma once

#include <map>
#include <string>
#include <vector>

#include "report/fleet_judgement.hpp"

namespace tagcal::tools {

// Adds how each serial with two dates or more changed, and judges its latest calibration, if that
// is ok until then, by it. `serials`: their calibrations by date.
void judge_drifts(Fleet& fleet, const std::map<std::string, std::vector<std::size_t>>& serials,
                  int threads);

}  // namespace tagcal::tools
