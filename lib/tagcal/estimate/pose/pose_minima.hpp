#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

namespace tagcal::internal {

// The least-squares poses of one view, in the plane's frame: the best first, then those within
// policy::kAmbiguousCost of it. N = 6: pose, 7: pose and focal length.
template <int N>
struct PoseMinima {
  Solutions<PoseMinimum<N>, 4> poses;
  NoiseLevel noise;

  const PoseMinimum<N>& best() const { return poses.front(); }

  // The largest cost of a pose beside the best one.
  double largest_cost() const {
    return best().cost + policy::kAmbiguousCost * noise.sigma_px * noise.sigma_px;
  }
  // Drops the poses that the noise excludes.
  void prune() {
    while (poses[poses.size() - 1].cost > largest_cost()) poses.pop_back();
  }
};

// True if two minima are one, at which the solver stopped twice.
template <int N>
bool is_same_minimum(const PoseMinimum<N>& a, const PoseMinimum<N>& b, double sigma_px);

// Refines the closed forms that suit the shape of the points (refine_pose). No value if no start
// lies in the lens' domain. For N = 7 the lens is a pinhole whose focal length is a guess. `noise`
// replaces that of the options.
// Precondition: points in a plane or in space, four or more, finite.
template <int N>
std::optional<PoseMinima<N>> pose_minima(const PoseProblem& problem, const Lens& lens,
                                         const PoseOptions& options,
                                         const std::optional<NoiseLevel>& noise = std::nullopt);

}  // namespace tagcal::internal
