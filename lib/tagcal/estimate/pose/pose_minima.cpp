#include "tagcal/estimate/pose/pose_minima.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/initial_poses.hpp"

namespace tagcal::internal {
namespace {

template <int N>
double squared_distance(const PoseMinimum<N>& from, const ViewState& to, double variance) {
  Eigen::Matrix<double, N, 1> step;
  step.template head<6>() = minus(pose_of(to), pose_of(from.state));
  if constexpr (N == 7) step[6] = std::log(to.focal_px / from.state.focal_px);
  const auto information = from.information.template selfadjointView<Eigen::Upper>();
  return step.dot(information * step) / variance;
}

}  // namespace

template <int N>
bool is_same_minimum(const PoseMinimum<N>& a, const PoseMinimum<N>& b, double sigma_px) {
  // sigma^2, of the costs and of the squared Mahalanobis distances.
  constexpr double kLimit = 0.1;  // numeric: convergence
  const double variance = sigma_px * sigma_px;
  return std::abs(a.cost - b.cost) < kLimit * variance &&
         squared_distance(a, b.state, variance) < kLimit &&
         squared_distance(b, a.state, variance) < kLimit;
}

template <int N>
std::optional<PoseMinima<N>> pose_minima(const PoseProblem& problem, const Lens& lens,
                                         const PoseOptions& options,
                                         const std::optional<NoiseLevel>& noise) {
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
    PoseMinimum<N>* const same = std::ranges::find_if(fit->poses, [&](const auto& other) {
      return is_same_minimum(other, *solution, fit->noise.sigma_px);
    });
    if (same == fit->poses.end()) {
      fit->poses.insert(*solution, has_less_cost);
    } else if (has_less_cost(*solution, *same)) {
      *same = *solution;
      for (auto* at = same; at > fit->poses.begin() && has_less_cost(*at, at[-1]); --at)
        std::swap(*at, at[-1]);
    }
    fit->noise = noise ? *noise : noise_level(problem, options, fit->best().cost, N);
    limit = fit->largest_cost();
    solver.ruled_out_cost = limit;
    fit->prune();
  }
  if (fit->poses.empty()) return std::nullopt;
  return fit;
}

template bool is_same_minimum(const PoseMinimum<6>&, const PoseMinimum<6>&, double);
template std::optional<PoseMinima<6>> pose_minima<6>(const PoseProblem&, const Lens&,
                                                     const PoseOptions&,
                                                     const std::optional<NoiseLevel>&);
template std::optional<PoseMinima<7>> pose_minima<7>(const PoseProblem&, const Lens&,
                                                     const PoseOptions&,
                                                     const std::optional<NoiseLevel>&);

}  // namespace tagcal::internal
