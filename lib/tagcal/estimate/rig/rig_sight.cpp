#include "tagcal/estimate/rig/rig_sight.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

Matrix6 transformed(const Matrix6& by, const Matrix6& covariance) {
  return by * covariance * by.transpose();
}

Matrix6 turned_by(const Eigen::Matrix3d& rotation) {
  return step_by(rotation, Eigen::Vector3d::Zero());
}

// Neighbouring instants of a trajectory, `middle` and the next one around a time.
struct Nodes {
  std::size_t first = 0, middle = 0, last = 0;
};

// At most six instants that follow one another, at most three on a side of the time.
std::optional<Nodes> nodes_around(const RigState& state, double time,
                                  const Trajectory& trajectory) {
  constexpr std::ptrdiff_t kOnASide = 3;  // numeric: with 2 slow waves err by 1e-4 of a period
  constexpr double kBeyond = 0.1;         // numeric: of the distance of two instants
  const auto follows = [&](std::ptrdiff_t k) {  // instant k follows k - 1
    const auto i = static_cast<std::size_t>(k);
    return k > 0 && i < trajectory.size() && trajectory[i] && trajectory[i - 1] &&
           state.time[i] > state.time[i - 1] &&
           (!state.has_stamps || state.time[i] - state.time[i - 1] <= policy::kLongestGap);
  };
  // A little beyond an end, so that the views of an offset by whole instants do not depend on its
  // last digits.
  const auto reaches = [&](std::ptrdiff_t k) {
    if (!follows(k)) return false;
    const double from = state.time[static_cast<std::size_t>(k - 1)];
    const double to = state.time[static_cast<std::size_t>(k)];
    return time >= from - kBeyond * (to - from) && time <= to + kBeyond * (to - from);
  };
  std::ptrdiff_t upper = std::ranges::upper_bound(state.time, time) - state.time.begin();
  if (!reaches(upper)) upper += reaches(upper - 1) ? -1 : 1;
  if (!reaches(upper)) return std::nullopt;
  std::ptrdiff_t first = upper - 1, last = upper;
  while (first > upper - kOnASide && follows(first)) --first;
  while (last < upper + kOnASide - 1 && follows(last + 1)) ++last;
  if (last - first < 2) return std::nullopt;
  return Nodes{static_cast<std::size_t>(first), static_cast<std::size_t>(upper - 1),
               static_cast<std::size_t>(last)};
}

}  // namespace

Connected without(Connected connected, std::size_t camera) {
  connected.cameras[camera] = 0;
  return connected;
}

WorldOfView world_of_instants(const RigState& state, std::size_t camera,
                              const Trajectory& trajectory, int shift) {
  return [&state, &trajectory, camera, shift](std::size_t view) -> std::optional<Sight> {
    const auto at = static_cast<std::ptrdiff_t>(*state.instant[camera][view]) + shift;
    if (at < 0 || at >= std::ssize(trajectory)) return std::nullopt;
    const auto& sight = trajectory[static_cast<std::size_t>(at)];
    if (!sight) return std::nullopt;
    const Pose& motion = state.poses.links[camera][view].motion;
    return Sight{motion * sight->rig_from_world,
                 transformed(turned_by(motion.rotation_matrix()), sight->covariance)};
  };
}

std::vector<Clue> clues_of_camera(const RigState& state, std::size_t camera,
                                  const WorldOfView& world, const Connected& connected) {
  std::vector<Clue> clues;
  for (std::size_t v = 0; v < state.instant[camera].size(); ++v) {
    const auto& t = state.instant[camera][v];
    const LinkedPoses::Link& link = state.poses.links[camera][v];
    if (!t || !connected.boards[link.board]) continue;
    const std::optional<Sight> sight = world(v);
    if (!sight) continue;
    const Pose& board = state.poses.world_from_board[link.board];
    Clue clue{camera, v, *t, {}, sight->rig_from_world * board};
    clue.of_right = transformed(step_by(Eigen::Matrix3d::Identity(),
                                        sight->rig_from_world.rotation() * board.translation()),
                                sight->covariance);
    clues.push_back(clue);
  }
  return clues;
}

std::vector<Clue> clues_of_board(const RigState& state, std::size_t board,
                                 const Trajectory& trajectory, const Connected& connected) {
  std::vector<Clue> clues;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!connected.cameras[c]) continue;
    for (std::size_t v = 0; v < state.instant[c].size(); ++v) {
      const auto& t = state.instant[c][v];
      const LinkedPoses::Link& link = state.poses.links[c][v];
      if (!t || link.board != board || !trajectory[*t]) continue;
      const Pose moved = state.poses.camera_from_rig[c] * link.motion;
      Clue clue{c, v, *t, moved * trajectory[*t]->rig_from_world, {}};
      clue.of_whole = transformed(
          step_by(moved.rotation_matrix(),
                  moved.rotation().conjugate() *
                          (state.own[c][v].camera_from_world.translation() - moved.translation()) -
                      trajectory[*t]->rig_from_world.translation()),
          trajectory[*t]->covariance);
      clues.push_back(clue);
    }
  }
  return clues;
}

Disagreement disagreement_of(const RigState& state, const Clue& clue, const Pose& own_pose,
                             const Pose& place) {
  Disagreement d;
  d.instant = clue.instant;
  d.view = clue.view;
  d.step = minus(clue.left * place * clue.right, own_pose);
  const Pose to_right = clue.left * place;
  d.covariance = state.own[clue.camera][clue.view].covariance + clue.of_whole +
                 transformed(turned_by(to_right.rotation_matrix()), clue.of_right);
  return d;
}

double Disagreement::square() const {
  const Eigen::Matrix<double, 6, 6> c = covariance;
  return step.dot(Eigen::LDLT<Eigen::Matrix<double, 6, 6>>(c).solve(step));
}

Pose world_by_view(const RigState& state, std::size_t camera, std::size_t view) {
  const LinkedPoses::Link& link = state.poses.links[camera][view];
  return (state.poses.camera_from_rig[camera] * link.motion).inverse() *
         state.own[camera][view].camera_from_world *
         state.poses.world_from_board[link.board].inverse();
}

Trajectory trajectory_of(const RigState& state, const Connected& connected) {
  Trajectory trajectory(state.num_instants);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!connected.cameras[c]) continue;
    for (std::size_t v = 0; v < state.own[c].size(); ++v) {
      const LinkedPoses::Link& link = state.poses.links[c][v];
      if (!state.instant[c][v] || !connected.boards[link.board]) continue;
      std::optional<Sight>& sight = trajectory[*state.instant[c][v]];
      const OwnPose& own = state.own[c][v];
      if (sight && sight->covariance.trace() <= own.covariance.trace()) continue;
      const Pose camera_from_moved = state.poses.camera_from_rig[c] * link.motion;
      const Pose board_from_world = state.poses.world_from_board[link.board].inverse();
      const Matrix6 by_own =
          step_by(camera_from_moved.rotation_matrix().transpose(),
                  own.camera_from_world.rotation() * board_from_world.translation());
      sight = Sight{world_by_view(state, c, v), transformed(by_own, own.covariance)};
    }
  }
  return trajectory;
}

std::vector<Disagreement> disagreements(const RigState& state, std::size_t camera,
                                        const Pose& camera_from_rig, const WorldOfView& world,
                                        const Connected& connected) {
  std::vector<Disagreement> result;
  for (const Clue& clue : clues_of_camera(state, camera, world, connected))
    result.push_back(disagreement_of(state, clue, state.own[camera][clue.view].camera_from_world,
                                     camera_from_rig));
  return result;
}

std::optional<MovingSight> world_at(const RigState& state, double time,
                                    const Trajectory& trajectory) {
  const auto nodes = nodes_around(state, time, trajectory);
  if (!nodes) return std::nullopt;
  const Pose& origin = trajectory[nodes->middle]->rig_from_world;
  // Lagrange's polynomial of the steps from `origin`, and its derivative.
  Vector6d step = Vector6d::Zero(), rate = Vector6d::Zero();
  for (std::size_t i = nodes->first; i <= nodes->last; ++i) {
    double weight = 1, slope = 0;
    for (std::size_t k = nodes->first; k <= nodes->last; ++k) {
      if (k == i) continue;
      const double width = state.time[i] - state.time[k];
      slope = slope * (time - state.time[k]) / width + weight / width;
      weight *= (time - state.time[k]) / width;
    }
    const Vector6d of_node = minus(trajectory[i]->rig_from_world, origin);
    step += weight * of_node;
    rate += slope * of_node;
  }
  // The rotation turns the rate of its own axis, to first order.
  const Eigen::Vector3d turn = step.head<3>(), turn_rate = rate.head<3>();
  rate.head<3>() += turn.cross(turn_rate) / 2;
  return MovingSight{{retract(origin, step), trajectory[nodes->middle]->covariance}, rate};
}

}  // namespace tagcal::internal
