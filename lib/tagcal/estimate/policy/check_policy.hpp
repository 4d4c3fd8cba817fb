#pragma once

// The numbers that decide the check of a camera (check_camera.hpp), as policy.hpp.

namespace tagcal::internal::policy {

// Probability of `changed` for a camera that did not change; 2.326 is its quantile of the normal
// distribution. A check may run daily: a false alarm in a hundred days.
inline constexpr double kFalseAlarm = 0.01;
inline constexpr double kCheckQuantile = 2.326;
// The change that theory says is found 99 times of 100 is found 84 times, and twice that change 96
// to 99 times, because noise and spread of few views are estimated (check_camera_test, 300 worlds
// of 5 pictures). So twice that change is stated, with the probability that was measured.
inline constexpr double kStatedOverTheory = 2;
inline constexpr double kDetectionPower = 0.95;

// Pictures below which the verdict is no other than cannot_tell: what one picture shows, as a bend
// of the board, may look like a lens.
inline constexpr int kFewestCheckedViews = 2;

// By this share of the widths of lens_prior the free camera may depart from the known one where the
// pictures do not determine it: it only keeps the linear test near the known camera. Chosen by
// hand: a twentieth of the cameras' own spread is 3.5 % of a focal length.
inline constexpr double kChangeShare = 0.05;

// Share of a view's corners below which its inliers are no longer that view: it is rejected.
inline constexpr double kLeastInlierShare = 0.5;

// Corners on which the check of one picture beside its pose may rest: degrees of freedom beside
// those of pose and lens (policy.hpp, kEnoughDegreesOfFreedom, has the accuracy of their noise).
inline constexpr int kFewestCheckedCorners = 40;

}  // namespace tagcal::internal::policy
