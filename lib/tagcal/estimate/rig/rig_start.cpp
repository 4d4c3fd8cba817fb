#include "tagcal/estimate/rig/rig_start.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostCandidates = 40;  // numeric: a limit of work
constexpr std::size_t kMostJudges = 60;      // numeric: a limit of work

// A covariance in a frame that is turned.
Matrix6 turned_covariance(const Matrix6& covariance, const Eigen::Matrix3d& rotation) {
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = rotation;
  turn.bottomRightCorner<3, 3>() = rotation;
  return turn * covariance * turn.transpose();
}

// A view of a camera at an instant of the trajectory.
struct CommonView {
  std::size_t view;
  Sight sight;  // at the time of the view
  std::size_t instant;
};

std::vector<CommonView> common_views(const RigState& state, std::size_t camera,
                                     const Trajectory& trajectory, int shift) {
  std::vector<CommonView> common;
  for (std::size_t v = 0; v < state.instant[camera].size(); ++v) {
    const auto& t = state.instant[camera][v];
    if (!t) continue;
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(*t) + shift;
    if (at < 0 || at >= std::ssize(trajectory)) continue;
    if (const auto& sight = trajectory[static_cast<std::size_t>(at)]) {
      const Pose& motion = state.poses.links[camera][v].motion;
      common.push_back({v, {motion * sight->rig_from_world, sight->covariance}, *t});
    }
  }
  return common;
}

Disagreement disagreement_of(const CommonView& common, const OwnPose& own, const Pose& own_pose,
                             const Pose& camera_from_rig) {
  Disagreement d;
  d.instant = common.instant;
  d.view = common.view;
  d.step = minus(camera_from_rig * common.sight.rig_from_world, own_pose);
  d.covariance = own.covariance +
                 turned_covariance(common.sight.covariance, camera_from_rig.rotation_matrix());
  return d;
}

// Evenly spread members.
std::vector<std::size_t> spread_indices(std::size_t n, std::size_t most) {
  std::vector<std::size_t> indices;
  const std::size_t count = std::min(n, most);
  for (std::size_t i = 0; i < count; ++i) indices.push_back(i * n / count);
  return indices;
}

// The own poses that a view may have: as it is, and turned.
std::vector<Pose> poses_of_view(const OwnPose& own, const std::optional<Pose>& half_turn) {
  std::vector<Pose> poses = {own.camera_from_world};
  if (half_turn) poses.push_back(own.camera_from_world * *half_turn);
  return poses;
}

// The least square of the disagreement of a view, and the index of its pose.
std::pair<double, std::size_t> least_square(const CommonView& common, const OwnPose& own,
                                            const std::optional<Pose>& half_turn,
                                            const Pose& camera_from_rig) {
  std::pair<double, std::size_t> least{std::numeric_limits<double>::infinity(), 0};
  const std::vector<Pose> poses = poses_of_view(own, half_turn);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double square = disagreement_of(common, own, poses[i], camera_from_rig).square();
    if (square < least.first) least = {square, i};
  }
  return least;
}

// The instants at which the camera is nearest to the trajectory have the say of the rig's place.
void set_instants(RigState& state, const Trajectory& trajectory) {
  for (std::size_t t = 0; t < trajectory.size(); ++t)
    if (trajectory[t]) state.poses.rig_from_world[t] = trajectory[t]->rig_from_world;
}

// Shifts are tried where a camera disagrees by more than the noise could explain (a ratio of
// variances): the trial costs eleven searches.
constexpr int kMostShift = 5;  // numeric: a limit of work
bool may_be_shifted(const CameraStart& start) {
  return start.median_square > 6 * policy::kOutlierSigmas * policy::kOutlierSigmas;
}

std::optional<InstantShift> shift_of(const RigState& state, std::size_t camera,
                                     const Trajectory& trajectory,
                                     const std::optional<Pose>& half_turn,
                                     const CameraStart& unshifted) {
  InstantShift best{camera, 0};
  double least = unshifted.median_square;
  for (int shift = -kMostShift; shift <= kMostShift; ++shift) {
    if (shift == 0) continue;
    const auto start = camera_start(state, camera, trajectory, half_turn, shift);
    if (start && start->median_square < least) {
      least = start->median_square;
      best.instants = shift;
    }
  }
  // By the same bound: half of the views must agree several times better.
  const double gain = unshifted.median_square / least;
  if (best.instants == 0 || gain < policy::kHalvesDisagree * policy::kHalvesDisagree)
    return std::nullopt;
  return best;
}

}  // namespace

double Disagreement::square() const {
  const Eigen::Matrix<double, 6, 6> c = covariance;
  return step.dot(Eigen::LDLT<Eigen::Matrix<double, 6, 6>>(c).solve(step));
}

Trajectory trajectory_of(const RigState& state, const std::vector<std::uint8_t>& is_connected) {
  Trajectory trajectory(state.num_instants);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!is_connected[c]) continue;
    for (std::size_t v = 0; v < state.own[c].size(); ++v) {
      if (!state.instant[c][v]) continue;
      std::optional<Sight>& sight = trajectory[*state.instant[c][v]];
      const OwnPose& own = state.own[c][v];
      if (sight && sight->covariance.trace() <= own.covariance.trace()) continue;
      const Pose rig_from_camera =
          (state.poses.camera_from_rig[c] * state.poses.links[c][v].motion).inverse();
      sight = Sight{rig_from_camera * own.camera_from_world,
                    turned_covariance(own.covariance, rig_from_camera.rotation_matrix())};
    }
  }
  return trajectory;
}

std::vector<Disagreement> disagreements(const RigState& state, std::size_t camera,
                                        const Pose& camera_from_rig, const Trajectory& trajectory) {
  std::vector<Disagreement> result;
  for (const CommonView& common : common_views(state, camera, trajectory, 0)) {
    const OwnPose& own = state.own[camera][common.view];
    result.push_back(disagreement_of(common, own, own.camera_from_world, camera_from_rig));
  }
  return result;
}

std::optional<CameraStart> camera_start(const RigState& state, std::size_t camera,
                                        const Trajectory& trajectory,
                                        const std::optional<Pose>& half_turn, int shift) {
  const std::vector<CommonView> common = common_views(state, camera, trajectory, shift);
  if (common.empty() || (shift != 0 && common.size() < policy::kEnoughForMedian))
    return std::nullopt;
  const auto own = [&](std::size_t i) -> const OwnPose& {
    return state.own[camera][common[i].view];
  };
  const std::vector<std::size_t> judges = spread_indices(common.size(), kMostJudges);
  CameraStart best;
  best.median_square = std::numeric_limits<double>::infinity();
  for (const std::size_t i : spread_indices(common.size(), kMostCandidates)) {
    for (const Pose& pose : poses_of_view(own(i), half_turn)) {
      const Pose candidate = pose * common[i].sight.rig_from_world.inverse();
      std::vector<double> squares;
      for (const std::size_t j : judges)
        squares.push_back(least_square(common[j], own(j), half_turn, candidate).first);
      const double square = median(std::move(squares));
      if (square < best.median_square) best = {candidate, square, {}};
    }
  }
  for (std::size_t i = 0; half_turn && i < common.size(); ++i)
    if (least_square(common[i], own(i), half_turn, best.camera_from_rig).second == 1)
      best.turned.push_back(common[i].view);
  return best;
}

int common_instants(const RigState& state, std::size_t a, std::size_t b) {
  const auto of_a = state.views_at(a), of_b = state.views_at(b);
  int count = 0;
  for (std::size_t t = 0; t < state.num_instants; ++t) count += of_a[t] && of_b[t];
  return count;
}

std::vector<std::vector<std::size_t>> connected_groups(const RigState& state) {
  const std::size_t n = state.cameras.size();
  std::vector<std::uint8_t> seen(n, 0);
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = (state.poses.reference + i) % n;
    if (seen[first]) continue;
    std::vector<std::size_t> group = {first};
    seen[first] = 1;
    for (std::size_t k = 0; k < group.size(); ++k)
      for (std::size_t c = 0; c < n; ++c)
        if (!seen[c] && common_instants(state, group[k], c) > 0) {
          seen[c] = 1;
          group.push_back(c);
        }
    std::ranges::sort(group);
    groups.push_back(group);
  }
  return groups;
}

RigStart start_rig(RigState& state, const std::optional<Pose>& half_turn) {
  const std::size_t n = state.cameras.size();
  RigStart start;
  start.is_connected.assign(n, 0);
  start.is_connected[state.poses.reference] = 1;
  for (;;) {
    const Trajectory trajectory = trajectory_of(state, start.is_connected);
    set_instants(state, trajectory);
    std::size_t next = n, most = 0;
    for (std::size_t c = 0; c < n; ++c) {
      if (start.is_connected[c]) continue;
      const std::size_t count = common_views(state, c, trajectory, 0).size();
      if (count > most) std::tie(next, most) = std::pair(c, count);
    }
    if (next == n) return start;
    const auto found = camera_start(state, next, trajectory, half_turn);
    if (may_be_shifted(*found))
      if (const auto shift = shift_of(state, next, trajectory, half_turn, *found))
        start.shifts.push_back(*shift);
    state.poses.camera_from_rig[next] = found->camera_from_rig;
    start.is_connected[next] = 1;
    for (const std::size_t view : found->turned) {
      turn_view(state, next, view, *half_turn);
      start.turned.emplace_back(next, view);
    }
  }
}

}  // namespace tagcal::internal
