#pragma once

#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

namespace tagcal::internal {

template <int N>
using InitialPoses = Solutions<InitialPose<N>, 16>;  // four triples of points, four poses each

// The order of starts and minima.
inline constexpr auto has_less_cost = [](const auto& a, const auto& b) { return a.cost < b.cost; };

// Starts for refine_pose: the closed forms that suit the shape of the points, the lowest cost
// first. They use a subset of many points. Empty if none puts every point into the lens' domain.
InitialPoses<6> initial_poses(const PoseProblem& problem, const Lens& lens);

// The same with a focal length. `guess` is a pinhole whose focal length serves the views for which
// no closed form gives one.
InitialPoses<7> initial_poses_with_focal(const PoseProblem& problem, const Lens& guess,
                                         ViewSums& sums);

// Computes the rays of pixels; false if one pixel has none.
bool find_rays(const Lens& lens, std::span<const Eigen::Vector2d> pixels,
               std::span<Eigen::Vector3d> rays);

// Principal point of a pinhole.
Eigen::Vector2d principal_point(const Lens& pinhole);

}  // namespace tagcal::internal
