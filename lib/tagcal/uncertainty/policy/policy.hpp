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

// ---- Whether a calibration changed: new pictures against it (check_camera.hpp), or two of them
// (lens_difference.hpp)

// Probability of `changed` for a camera that did not change; 2.326 is its quantile of the normal
// distribution. A check may run daily: a false alarm in a hundred days.
inline constexpr double kFalseAlarm = 0.01;
inline constexpr double kCheckQuantile = 2.326;
// Probability with which the stated smallest change is found. Its size is that of a non-central
// chi-square that is found 99 times of 100 (kCheckQuantile); 98 to 99 times were counted, because
// the spread of few views is estimated (check_camera_test).
inline constexpr double kDetectionPower = 0.98;

// Share of the variance of two lenses' difference, over all samples: directions with less count
// less in their comparison. Source: between 1e-4 and 1e-2 the score of OpenCV's `left` against
// `right` falls from 6.6 to 2.7, and those of random halves of six real sets stay below 3.
inline constexpr double kNegligibleShare = 1e-3;

}  // namespace tagcal::internal::policy
