#pragma once

#include <cstddef>
#include <vector>

#include "tagcal/estimate/fit.hpp"

namespace tagcal {

// The fit with the lowest BIC on all corners, each counted up to the rejection bound (Torr, IJCV
// 2002: the robust form), with the noise of the best fit. A perspective counts as the leanest of
// its sub-models (no distortion; k1; k1 k2; k1 k2 p1 p2) that explains the data: else a fisheye,
// which has a parameter less and bends to much the same images, would win on every ordinary lens.
// Sets `bic` of each. Precondition: not empty.
std::size_t choose_fit(std::vector<CalibrationFit>& fits);

}  // namespace tagcal
