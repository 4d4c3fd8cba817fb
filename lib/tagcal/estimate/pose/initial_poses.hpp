#pragma once

#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

namespace tagcal::internal {

template <int N>
using ViewStarts = Solutions<ViewStart<N>, 16>;  // four triples of points, four poses each

// Where solve_view may begin: the closed forms that suit the shape of the points, those of lower
// cost first. Of many points some are enough for that. Empty where none puts every point in the
// lens' domain.
ViewStarts<6> find_starts(const PoseProblem& problem, const Lens& lens);

// The same with a focal length; `guess` is a pinhole, for where no closed form tells.
ViewStarts<7> find_starts_with_focal(const PoseProblem& problem, const Lens& guess, ViewSums& sums);

// The rays of pixels; false where one has none.
bool find_rays(const Lens& lens, std::span<const Eigen::Vector2d> pixels,
               std::span<Eigen::Vector3d> rays);

// The principal point of a pinhole.
Eigen::Vector2d principal_point(const Lens& pinhole);

}  // namespace tagcal::internal
