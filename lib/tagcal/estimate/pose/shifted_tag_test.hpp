#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {

// The group (a tag) that is most surely off its place, where one is. A tag that is a few pixels off
// pulls a pose of few others to itself, until none of its corners is an outlier; together they are:
// letting it move in the image takes away more of the sum of squares than noise can be blamed for
// (the mean-shift outlier model, Cook & Weisberg, Residuals and Influence in Regression,
// 1982, 2.2). `state` is the least-squares state of the problem, `groups` has the group of each of
// its points. No value where too few would stay to say it. N = 6: pose, 7: pose and focal length.
template <int N>
std::optional<int> odd_group(const PoseProblem& problem, std::span<const int> groups,
                             const Lens& lens, const ViewState& state);

extern template std::optional<int> odd_group<6>(const PoseProblem&, std::span<const int>,
                                                const Lens&, const ViewState&);
extern template std::optional<int> odd_group<7>(const PoseProblem&, std::span<const int>,
                                                const Lens&, const ViewState&);

}  // namespace tagcal::internal
