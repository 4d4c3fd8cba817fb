#pragma once

// The test for rolling shutters (bundle/rolling_shutter.hpp).

namespace tagcal::internal::policy {

// Logarithm of the likelihood that effects by row must gain on those by row and column, and on
// none. A normal variable that is off by 6 standard deviations gains 18 (6^2 / 2), and less than
// this in 0.2 % of samples; one that is not off gains this in 0.08 % (study shutter).
inline constexpr double kRollingGain = 5;

// Neighbours in time, for the velocity of a view, are at most this far apart: 10 pictures a second
// with uneven times. The derivative of a polynomial through five poses is wrong by a share of
// (2 pi f 0.1 s)^4 / 30 at a motion of f Hz: 0.5 % at 1 Hz, 8 % at 2 Hz; at 30 pictures a second 0.1
// % at 2 Hz. The scatter of the views shows it, and is in the standard deviation.
inline constexpr double kNeighbourSeconds = 0.12;

}  // namespace tagcal::internal::policy
