#pragma once

#include <span>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// Which views repeat a pose: the number of each view's pose, in the order of the first view of
// each. Two views have one pose if the points that a view sees move by less than policy::kSamePose
// of the image's diagonal (RMS) from the one to the other. Such views are not independent: what
// detector, lens and board leave in their corners is the same in all of them.
std::vector<std::size_t> pose_numbers(const Bundle& bundle);
// How many poses these are.
std::size_t num_poses(std::span<const std::size_t> pose_of_view);

// By how much the variance of a mean over views exceeds that of independent ones, as far as the
// residuals show it: 1 + (m - 1) r for m views of a pose (the mean, weighed by views), and r the
// correlation of the residuals of one point in views of one pose, >= 0 (Kish 1965, section 5.4).
double design_effect(const Bundle& solved, std::span<const std::size_t> pose_of_view);

}  // namespace tagcal::internal
