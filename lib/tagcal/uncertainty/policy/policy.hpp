#pragma once

// Every number that decides an uncertainty or a sentence about it, as estimate/policy/policy.hpp.

namespace tagcal::internal::policy {

// Parts of the image without corners (seen_region.cpp): a corner of the image counts as seen if the
// point at this share of width and height from it is in the hull. Chosen by hand.
inline constexpr double kCornerInset = 0.2;

// Triangulated points (triangulate.cpp). The inverse of the distance must be this many standard
// deviations above zero: the distance then has a standard deviation of at most a third, for which
// that of its linear propagation is right to 20 %.
inline constexpr double kFarSigmas = 3;
// Pixels contradict one another if the squared residuals exceed the chi-square quantile of this
// normal quantile: one of 741 points whose covariances are right.
inline constexpr double kContradictionSigmas = 3;
// Pixels are given as decimals or as float32: no noise is less than this, px.
inline constexpr double kLeastPixelNoise = 1e-3;

}  // namespace tagcal::internal::policy
