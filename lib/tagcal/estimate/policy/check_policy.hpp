#pragma once

#include "tagcal/uncertainty/policy/policy.hpp"

// The numbers that decide the check of a camera (check_camera.hpp), as policy.hpp; those that it
// shares with a comparison of two calibrations stand in uncertainty/policy.

namespace tagcal::internal::policy {

// Poses of the board below which the verdict is no other than cannot_tell: what one pose shows, as
// a bend of the board, may look like a lens.
inline constexpr std::size_t kFewestCheckedPoses = 2;

// By this share of the widths of lens_prior the free camera may depart from the known one where the
// pictures do not determine it; it only keeps the linear test near the known camera. Chosen by
// hand. With a twentieth, the free camera stayed so near the known one that in 65 of 100 changed
// worlds of five pictures row terms explained a changed principal point: 86 instead of 99 were
// found.
inline constexpr double kChangeShare = 0.5;

// RMS of the residuals of a free rig over that of the known lenses with a pose for each picture:
// beyond it the pictures of an instant were not taken at one time. Source: the data; exchanged
// instants give 750, rigs whose cameras moved or changed at most 1.1.
inline constexpr double kStrainedCheck = 2;

// Share of a view's corners below which its inliers are no longer that view: it is rejected.
inline constexpr double kLeastInlierShare = 0.5;

// Corners on which the check of one picture beside its pose may rest: degrees of freedom beside
// those of pose and lens (policy.hpp, kEnoughDegreesOfFreedom, has the accuracy of their noise).
inline constexpr int kFewestCheckedCorners = 40;

}  // namespace tagcal::internal::policy
