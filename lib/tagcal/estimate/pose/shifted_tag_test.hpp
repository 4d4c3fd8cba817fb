#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {

// Returns the group (a tag) that is most significantly off its place, if there is one. If there are
// few tags, one that is a few pixels off pulls the pose to itself, until none of its corners is an
// outlier. Its corners are tested together: a shift of the tag in the image then lowers the sum of
// squares by more than noise does (mean-shift outlier model, Cook & Weisberg, Residuals and
// Influence in Regression, 1982, 2.2). `state` is the least-squares state of the problem, `groups`
// has the group of each of its points. No value if too few points remain for the test. N = 6: pose,
// 7: pose and focal length.
template <int N>
std::optional<int> shifted_tag(const PoseProblem& problem, std::span<const int> groups,
                               const Lens& lens, const ViewState& state);

}  // namespace tagcal::internal
