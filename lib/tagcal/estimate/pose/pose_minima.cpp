#include "tagcal/estimate/pose/pose_minima.hpp"

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/initial_poses.hpp"

namespace tagcal::internal {
namespace {

bool is_same(const ViewState& a, const ViewState& b) {
  return (a.rotation - b.rotation).squaredNorm() < policy::kSameRotationSquare;
}

// Inserts a solution by its cost, unless it is there already.
template <int N>
void insert(const PoseMinimum<N>& solution, Solutions<PoseMinimum<N>, 4>& poses) {
  for (const PoseMinimum<N>& other : poses)
    if (is_same(solution.state, other.state)) return;
  poses.insert(solution,
               [](const PoseMinimum<N>& a, const PoseMinimum<N>& b) { return a.cost < b.cost; });
}

}  // namespace

template <int N>
std::optional<PoseMinima<N>> pose_minima(const PoseProblem& problem, const Lens& lens,
                                         const PoseOptions& options) {
  ViewSums sums(lens, problem.view());
  InitialPoses<N> starts;
  if constexpr (N == 6)
    starts = initial_poses(problem, lens);
  else
    starts = initial_poses_with_focal(problem, lens, sums);

  RefineOptions solver;
  solver.max_iterations = options.max_iterations;
  std::optional<PoseMinima<N>> fit(std::in_place);
  double limit = 0;  // largest cost of a candidate
  for (const InitialPose<N>& start : starts) {
    if (!fit->poses.empty() && !start.has_equations && start.cost > limit) continue;
    const auto solution = refine_pose<N>(sums, start, solver);
    if (!solution || (!fit->poses.empty() && solution->cost > limit)) continue;
    insert(*solution, fit->poses);
    fit->noise = noise_level(problem, options, fit->best().cost, N);
    limit = fit->best().cost + policy::kAmbiguousCost * fit->noise.sigma_px * fit->noise.sigma_px;
    solver.ruled_out_cost = limit;
    while (fit->poses[fit->poses.size() - 1].cost > limit) fit->poses.pop_back();
  }
  if (fit->poses.empty()) return std::nullopt;
  return fit;
}

template std::optional<PoseMinima<6>> pose_minima<6>(const PoseProblem&, const Lens&,
                                                     const PoseOptions&);
template std::optional<PoseMinima<7>> pose_minima<7>(const PoseProblem&, const Lens&,
                                                     const PoseOptions&);

}  // namespace tagcal::internal
