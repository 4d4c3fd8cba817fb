#include "tagcal/estimate/rig/rig_solve.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

// By instant of the data set: the views of which it has more than one.
std::map<std::size_t, std::vector<ViewExcess>> by_instant(const RigState& state,
                                                          const std::vector<ViewExcess>& all) {
  std::map<std::size_t, std::vector<ViewExcess>> instants;
  for (const ViewExcess& view : all)
    instants[*state.instant[view.camera][view.view]].push_back(view);
  return instants;
}

// Degrees of freedom that the rig takes from the poses of an instant.
int freedom_of(std::size_t num_views) { return 6 * (static_cast<int>(num_views) - 1); }

double sum_of_squares(const std::vector<ViewExcess>& views) {
  double sum = 0;
  for (const ViewExcess& view : views) sum += view.square;
  return sum;
}

// The views that contradict the rig: their instant's excess is that of outliers, by the median
// instant.
std::vector<ViewExcess> contradictions(const RigState& state) {
  const auto instants = by_instant(state, excesses(state));
  std::vector<double> ratios;
  for (const auto& [instant, views] : instants)
    ratios.push_back(sum_of_squares(views) / freedom_of(views.size()));
  if (ratios.size() < policy::kEnoughForMedian) return {};
  const double scale = std::max(1.0, median(ratios));
  std::vector<ViewExcess> result;
  std::size_t i = 0;
  for (const auto& [instant, views] : instants) {
    if (ratios[i++] <= policy::kOutlierSigmas * policy::kOutlierSigmas * scale) continue;
    if (views.size() == 2)
      result.insert(result.end(), views.begin(), views.end());
    else
      result.push_back(*std::ranges::max_element(views, {}, &ViewExcess::square));
  }
  return result;
}

}  // namespace

std::vector<CameraMove> separate_moves(RigState& state, const RigStart& start) {
  std::vector<CameraMove> moves;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!start.has(c) || c == state.poses.reference) continue;
    const Connected rest = without(start.connected, c);
    const Trajectory trajectory = trajectory_of(state, rest);
    const auto move = camera_move(state, c, trajectory, rest);
    if (!move) continue;
    moves.push_back(*move);
    std::size_t before = 0, after = 0;
    for (const auto& t : state.instant[c])
      if (t) ++(*t < move->instant ? before : after);
    for (std::size_t v = 0; v < state.instant[c].size(); ++v)
      if (const auto& t = state.instant[c][v]; t && (*t < move->instant) != (before >= after))
        state.set_alone(c, v);
    if (const auto again = camera_start(state, c, trajectory, rest, {}))
      state.poses.camera_from_rig[c] = again->place;
  }
  return moves;
}

std::vector<ViewExcess> excesses(const RigState& state) {
  std::map<std::size_t, int> count;
  for (const auto& camera : state.instant)
    for (const auto& t : camera)
      if (t) ++count[*t];
  std::vector<ViewExcess> all;
  for (std::size_t c = 0; c < state.cameras.size(); ++c)
    for (std::size_t v = 0; v < state.own[c].size(); ++v) {
      const auto& t = state.instant[c][v];
      if (!t || count[*t] < 2) continue;
      const double more = cost_of_view(state, c, v) - state.own[c][v].cost;
      const double of_noise = freedom_of(static_cast<std::size_t>(count[*t])) / (1.0 * count[*t]);
      all.push_back({c, v, std::max(0.0, more), of_noise,
                     static_cast<int>(state.cameras[c].views[v].correspondences.size())});
    }
  return all;
}

double excess_of_camera(const std::vector<ViewExcess>& all, std::size_t camera) {
  double square = 0;
  int count = 0;
  for (const ViewExcess& view : all) {
    if (view.camera != camera) continue;
    square += view.square - view.of_noise;
    count += 2 * view.num_corners;
  }
  return square > 0 ? std::sqrt(square / count) : 0;
}

double strain_of_rig(const RigState& state, Eigen::Index num_extrinsics) {
  double sum = 0, freedom = -static_cast<double>(num_extrinsics);
  for (const auto& [instant, views] : by_instant(state, excesses(state))) {
    sum += sum_of_squares(views);
    freedom += freedom_of(views.size());
  }
  return freedom > 0 ? std::max(1.0, sum / freedom) : 1.0;
}

RigSolution solve_robustly(RigState& state, const CalibrateOptions& options) {
  constexpr int kRounds = 10;  // a limit of work
  RigSolution solution;
  solution.num_rejected.assign(state.cameras.size(), 0);
  for (int round = 0; round < kRounds; ++round) {
    solution.summary =
        solve(state.cameras, state.poses, options.max_iterations, options.num_threads);
    solution.num_iterations += solution.summary.num_iterations;
    if (!options.reject_outliers) break;
    const std::vector<ViewExcess> wrong = contradictions(state);
    if (wrong.empty()) break;
    for (const ViewExcess& view : wrong) {
      solution.rejected.push_back(*state.instant[view.camera][view.view]);
      ++solution.num_rejected[view.camera];
      state.set_alone(view.camera, view.view);
    }
  }
  std::ranges::sort(solution.rejected);
  const auto repeated = std::ranges::unique(solution.rejected);
  solution.rejected.erase(repeated.begin(), repeated.end());
  return solution;
}

}  // namespace tagcal::internal
