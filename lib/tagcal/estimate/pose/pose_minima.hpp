#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

namespace tagcal::internal {

// Two poses are told apart where their costs differ by more than this many sigma^2. Of two whose
// pictures are d sigma apart the wrong one is better by T sigma^2 with the probability
// Q((d^2 + T) / 2 d), at most Q(sqrt T): 3e-5. (With T = 9 it is 1.3e-3, and was measured as that.)
inline constexpr double kAmbiguousCost = 16;

// The least-squares poses of one view, in the plane's frame: the best first, then those within
// kAmbiguousCost of it. N = 6: pose, 7: pose and focal length.
template <int N>
struct ViewFit {
  Solutions<ViewSolution<N>, 4> poses;
  NoiseLevel noise;

  const ViewSolution<N>& best() const { return poses.front(); }
};

// Closed form by the shape of the points, then solve_view. No value where no start lies in the
// lens' domain. Of pose with focal length, the lens is a pinhole whose focal length is a guess.
// Precondition: points in a plane or in space, four or more, finite.
template <int N>
std::optional<ViewFit<N>> fit_view(const PoseProblem& problem, const Lens& lens,
                                   const PoseOptions& options);

extern template std::optional<ViewFit<6>> fit_view<6>(const PoseProblem&, const Lens&,
                                                      const PoseOptions&);
extern template std::optional<ViewFit<7>> fit_view<7>(const PoseProblem&, const Lens&,
                                                      const PoseOptions&);

}  // namespace tagcal::internal
