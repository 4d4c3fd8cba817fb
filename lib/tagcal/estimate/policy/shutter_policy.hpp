#pragma once

// The test for rolling shutters (bundle/rolling_shutter.hpp).

namespace tagcal::internal::policy {

// Logarithm of the likelihood that effects by row must gain on those by row and column, and on
// none. A normal variable that is off by 6 standard deviations gains 18 (6^2 / 2), and less than
// this in 0.2 % of samples; one that is not off gains this in 0.08 % (study shutter).
inline constexpr double kRollingGain = 5;

}  // namespace tagcal::internal::policy
