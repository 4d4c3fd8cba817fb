#include "tagcal/estimate/pose/pose_minima.hpp"

#include "tagcal/estimate/pose/initial_poses.hpp"

namespace tagcal::internal {
namespace {

bool is_same(const ViewState& a, const ViewState& b) {
  return (a.rotation - b.rotation).squaredNorm() < 2e-8;  // angle below 1e-4
}

// Keeps the solutions sorted by cost, each once.
template <int N>
void insert(const ViewSolution<N>& solution, Solutions<ViewSolution<N>, 4>& poses) {
  for (const ViewSolution<N>& other : poses)
    if (is_same(solution.state, other.state)) return;
  poses.insert(solution,
               [](const ViewSolution<N>& a, const ViewSolution<N>& b) { return a.cost < b.cost; });
}

}  // namespace

template <int N>
std::optional<ViewFit<N>> fit_view(const PoseProblem& problem, const Lens& lens,
                                   const PoseOptions& options) {
  ViewSums sums(lens, problem.view());
  ViewStarts<N> starts;
  if constexpr (N == 6)
    starts = find_starts(problem, lens);
  else
    starts = find_starts_with_focal(problem, lens, sums);

  ViewSolverOptions solver;
  solver.max_iterations = options.max_iterations;
  std::optional<ViewFit<N>> fit(std::in_place);
  double limit = 0;  // of what is still a candidate
  for (const ViewStart<N>& start : starts) {
    if (!fit->poses.empty() && !start.has_equations && start.cost > limit) continue;
    const auto solution = solve_view<N>(sums, start, solver);
    if (!solution || (!fit->poses.empty() && solution->cost > limit)) continue;
    insert(*solution, fit->poses);
    fit->noise = noise_level(problem, options, fit->best().cost, N);
    limit = fit->best().cost + kAmbiguousCost * fit->noise.sigma_px * fit->noise.sigma_px;
    solver.ruled_out_cost = limit;
    while (fit->poses[fit->poses.size() - 1].cost > limit) fit->poses.pop_back();
  }
  if (fit->poses.empty()) return std::nullopt;
  return fit;
}

template std::optional<ViewFit<6>> fit_view<6>(const PoseProblem&, const Lens&, const PoseOptions&);
template std::optional<ViewFit<7>> fit_view<7>(const PoseProblem&, const Lens&, const PoseOptions&);

}  // namespace tagcal::internal
