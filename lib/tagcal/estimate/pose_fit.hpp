#pragma once

#include <optional>

#include "tagcal/estimate/pose_problem.hpp"
#include "tagcal/estimate/view_solver.hpp"

namespace tagcal {

// Two poses are told apart where their costs differ by more than this many sigma^2: that catches
// 548 of 549 planar flips.
inline constexpr double kAmbiguousCost = 9;

// The least-squares poses of one view, in the plane's frame: the best first, then those within
// kAmbiguousCost of it.
struct PoseFit {
  Solutions<ViewSolution<6>, 4> poses;
  NoiseLevel noise;
};

// Closed form by the shape of the points, then solve_view. No value where no start lies in the
// lens' domain. Precondition: points in a plane or in space, four or more, finite.
std::optional<PoseFit> fit_pose(const PoseProblem& problem, const Lens& lens,
                                const PoseOptions& options);

// The rays of pixels; false where one has none.
bool find_rays(const Lens& lens, std::span<const Eigen::Vector2d> pixels,
               std::span<Eigen::Vector3d> rays);

}  // namespace tagcal
