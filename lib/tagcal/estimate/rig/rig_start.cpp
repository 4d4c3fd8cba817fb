#include "tagcal/estimate/rig/rig_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/rig/motion_start.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostCandidates = 40;  // numeric: a limit of work
constexpr std::size_t kMostJudges = 60;      // numeric: a limit of work

// The own poses that a view may have: as it is, and turned.
std::vector<Pose> poses_of_view(const RigState& state, const Clue& clue,
                                const std::optional<Pose>& half_turn) {
  const Pose& own = state.own[clue.camera][clue.view].camera_from_world;
  std::vector<Pose> poses = {own};
  if (half_turn) poses.push_back(own * *half_turn);
  return poses;
}

// The least square of the disagreement of a view, and the index of its pose.
std::pair<double, std::size_t> least_square(const RigState& state, const Clue& clue,
                                            const std::optional<Pose>& half_turn,
                                            const Pose& place) {
  std::pair<double, std::size_t> least{std::numeric_limits<double>::infinity(), 0};
  const std::vector<Pose> poses = poses_of_view(state, clue, half_turn);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double square = disagreement_of(state, clue, poses[i], place).square();
    if (square < least.first) least = {square, i};
  }
  return least;
}

std::optional<PlaceStart> place_start(const RigState& state, std::span<const Clue> clues,
                                      const std::optional<Pose>& half_turn) {
  if (clues.empty()) return std::nullopt;
  const std::vector<std::size_t> judges = spread_indices(clues.size(), kMostJudges);
  PlaceStart best;
  best.median_square = std::numeric_limits<double>::infinity();
  for (const std::size_t i : spread_indices(clues.size(), kMostCandidates)) {
    for (const Pose& pose : poses_of_view(state, clues[i], half_turn)) {
      const Pose candidate = clues[i].left.inverse() * pose * clues[i].right.inverse();
      std::vector<double> squares;
      for (const std::size_t j : judges)
        squares.push_back(least_square(state, clues[j], half_turn, candidate).first);
      const double square = median(std::move(squares));
      if (square < best.median_square) best = {candidate, square, {}};
    }
  }
  for (std::size_t i = 0; half_turn && i < clues.size(); ++i)
    if (least_square(state, clues[i], half_turn, best.place).second == 1)
      best.turned.push_back(clues[i].view);
  return best;
}

void set_instants(RigState& state, const Trajectory& trajectory) {
  for (std::size_t t = 0; t < trajectory.size(); ++t)
    if (trajectory[t]) state.poses.rig_from_world[t] = trajectory[t]->rig_from_world;
}

// Takes the world of each instant from the view that agrees best with the others, because a view of
// a plane may have the other one of its two poses.
void choose_instants(RigState& state, const Connected& connected) {
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> views(state.num_instants);
  for (std::size_t c = 0; c < state.cameras.size(); ++c)
    for (std::size_t v = 0; connected.cameras[c] && v < state.own[c].size(); ++v)
      if (state.instant[c][v] && connected.boards[state.poses.links[c][v].board])
        views[*state.instant[c][v]].emplace_back(c, v);
  for (std::size_t t = 0; t < views.size(); ++t) {
    double least = std::numeric_limits<double>::infinity();
    Pose& world = state.poses.rig_from_world[t];
    Pose best = world;
    for (const auto& [candidate_camera, candidate_view] : views[t]) {
      world = world_by_view(state, candidate_camera, candidate_view);
      double sum = 0;
      for (const auto& [c, v] : views[t]) {
        const OwnPose& own = state.own[c][v];
        const Pose predicted = state.poses.camera_from_board(c, state.poses.links[c][v]);
        sum += Disagreement{t, v, minus(predicted, own.camera_from_world), own.covariance}.square();
      }
      if (sum >= least) continue;
      least = sum;
      best = world;
    }
    world = best;
  }
}

// Shifts are tried where a camera disagrees by more than the noise could explain (a ratio of
// variances): the trial costs eleven searches.
constexpr int kMostShift = 5;  // numeric: a limit of work
bool may_be_shifted(const PlaceStart& start) {
  return start.median_square > 6 * policy::kOutlierSigmas * policy::kOutlierSigmas;
}

std::optional<InstantShift> shift_of(const RigState& state, std::size_t camera,
                                     const Trajectory& trajectory, const Connected& connected,
                                     const std::optional<Pose>& half_turn,
                                     const PlaceStart& unshifted) {
  InstantShift best{camera, 0, {}};
  double least = unshifted.median_square;
  for (int shift = -kMostShift; shift <= kMostShift; ++shift) {
    if (shift == 0) continue;
    const auto start = camera_start(state, camera, trajectory, connected, half_turn, shift);
    if (start && start->median_square < least) {
      least = start->median_square;
      best.instants = shift;
      best.camera_from_rig = start->place;
    }
  }
  // By the same bound: half of the views must agree several times better.
  const double gain = unshifted.median_square / least;
  if (best.instants == 0 || gain < policy::kHalvesDisagree * policy::kHalvesDisagree)
    return std::nullopt;
  return best;
}

// A camera or a board that could be placed next, and the views that tell its place.
struct Next {
  bool is_camera = true;
  std::size_t index = 0;
  std::vector<Clue> clues;
};

std::optional<Next> next_to_place(const RigState& state, const Trajectory& trajectory,
                                  const Connected& connected) {
  std::optional<Next> next;
  const auto offer = [&](bool is_camera, std::size_t index, std::vector<Clue> clues) {
    if (!clues.empty() && (!next || clues.size() > next->clues.size()))
      next = Next{is_camera, index, std::move(clues)};
  };
  for (std::size_t c = 0; c < connected.cameras.size(); ++c)
    if (!connected.cameras[c])
      offer(true, c, clues_of_camera(state, c, world_of_instants(state, c, trajectory), connected));
  for (std::size_t b = 0; b < connected.boards.size(); ++b)
    if (!connected.boards[b]) offer(false, b, clues_of_board(state, b, trajectory, connected));
  return next;
}

void place_camera(RigState& state, const Next& next, const Trajectory& trajectory,
                  const std::optional<Pose>& half_turn, RigStart& start) {
  const std::size_t camera = next.index;
  const auto found = place_start(state, next.clues, half_turn);
  if (may_be_shifted(*found))
    if (const auto shift = shift_of(state, camera, trajectory, start.connected, half_turn, *found))
      start.shifts.push_back(*shift);
  state.poses.camera_from_rig[camera] = found->place;
  start.connected.cameras[camera] = 1;
  for (const std::size_t view : found->turned) {
    turn_view(state, camera, view, *half_turn);
    start.turned.emplace_back(camera, view);
  }
}

// Places the camera and the board, both not connected, that have the most views at known instants,
// by motion. Returns false if there are none.
bool place_by_motion(RigState& state, const Trajectory& trajectory, Connected& connected) {
  std::vector<MotionPair> most;
  std::size_t camera = 0, board = 0;
  for (std::size_t c = 0; c < connected.cameras.size(); ++c)
    for (std::size_t b = 0; !connected.cameras[c] && b < connected.boards.size(); ++b) {
      std::vector<MotionPair> views;
      for (std::size_t v = 0; !connected.boards[b] && v < state.instant[c].size(); ++v) {
        const auto& t = state.instant[c][v];
        const LinkedPoses::Link& link = state.poses.links[c][v];
        if (t && link.board == b && trajectory[*t])
          views.push_back(
              {state.own[c][v].camera_from_world, link.motion * trajectory[*t]->rig_from_world});
      }
      if (views.size() <= most.size()) continue;
      most = std::move(views);
      camera = c;
      board = b;
    }
  const auto start = motion_start(most);
  if (!start) return false;
  state.poses.camera_from_rig[camera] = start->camera_from_rig;
  state.poses.world_from_board[board] = start->world_from_board;
  connected.cameras[camera] = connected.boards[board] = 1;
  return true;
}

// The board that the reference sees most.
std::size_t first_board(const RigState& state) {
  std::vector<int> count(state.poses.world_from_board.size(), 0);
  for (const LinkedPoses::Link& link : state.poses.links[state.poses.reference])
    ++count[link.board];
  return static_cast<std::size_t>(std::ranges::max_element(count) - count.begin());
}

}  // namespace

std::optional<PlaceStart> camera_start(const RigState& state, std::size_t camera,
                                       const Trajectory& trajectory, const Connected& connected,
                                       const std::optional<Pose>& half_turn, int shift) {
  const std::vector<Clue> clues = clues_of_camera(
      state, camera, world_of_instants(state, camera, trajectory, shift), connected);
  if (shift != 0 && clues.size() < policy::kEnoughForMedian) return std::nullopt;
  return place_start(state, clues, half_turn);
}

int common_instants(const RigState& state, std::size_t a, std::size_t b) {
  const auto of_a = state.views_at(a), of_b = state.views_at(b);
  int count = 0;
  for (std::size_t t = 0; t < state.num_instants; ++t)
    count += !of_a[t].empty() && !of_b[t].empty();
  return count;
}

RigStart start_rig(RigState& state, const std::optional<Pose>& half_turn) {
  RigStart start;
  start.connected.cameras.assign(state.cameras.size(), 0);
  start.connected.cameras[state.poses.reference] = 1;
  start.connected.boards.assign(state.poses.world_from_board.size(), 0);
  state.poses.first_board = first_board(state);
  state.poses.world_from_board[state.poses.first_board] = {};
  start.connected.boards[state.poses.first_board] = 1;
  for (;;) {
    const Trajectory trajectory = trajectory_of(state, start.connected);
    set_instants(state, trajectory);
    const auto next = next_to_place(state, trajectory, start.connected);
    if (!next && !place_by_motion(state, trajectory, start.connected)) break;
    if (next && next->is_camera) place_camera(state, *next, trajectory, half_turn, start);
    if (next && !next->is_camera) {
      state.poses.world_from_board[next->index] = place_start(state, next->clues, {})->place;
      start.connected.boards[next->index] = 1;
    }
  }
  choose_instants(state, start.connected);
  return start;
}

std::vector<std::vector<std::size_t>> groups_of(const RigState& state, const RigStart& start) {
  const std::size_t n = state.cameras.size();
  std::vector<std::uint8_t> seen = start.connected.cameras;
  std::vector<std::vector<std::size_t>> groups(1);
  for (std::size_t c = 0; c < n; ++c)
    if (seen[c]) groups.front().push_back(c);
  for (std::size_t first = 0; first < n; ++first) {
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

}  // namespace tagcal::internal
