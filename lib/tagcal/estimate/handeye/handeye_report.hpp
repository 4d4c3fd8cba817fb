#pragma once

#include "tagcal/estimate/handeye/handeye_checks.hpp"
#include "tagcal/estimate/handeye/handeye_sights.hpp"

namespace tagcal::internal {

// Fills in an answer from a minimum: places and covariances, the robot's noise, views, spreads, and
// what refuses it.
void report_minimum(const HandeyeSights& sights, const HandeyeMinimum& minimum,
                    HandeyeEstimate& answer);

}  // namespace tagcal::internal
