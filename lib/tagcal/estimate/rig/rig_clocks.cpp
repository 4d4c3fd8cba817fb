#include "tagcal/estimate/rig/rig_clocks.hpp"

#include <algorithm>
#include <utility>

#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

// The motion of the world in the rig from a view's instant to a time, as other cameras saw it. No
// value if they do not tell it.
std::optional<Pose> motion_to(const RigState& state, std::size_t instant, double time,
                              const Trajectory& of_others) {
  if (time == state.time[instant]) return Pose();
  const auto world = world_at(state, time, of_others);
  if (!world || !of_others[instant]) return std::nullopt;
  return world->sight.rig_from_world * of_others[instant]->rig_from_world.inverse();
}

// Moves the world of each view to its time by its camera's clock, and returns the views (camera and
// view) for which that is not known.
std::vector<std::pair<std::size_t, std::size_t>> move_views(RigState& state, const RigStart& start,
                                                            const std::vector<double>& offsets) {
  std::vector<std::pair<std::size_t, std::size_t>> unknown;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const Trajectory of_others = trajectory_of(state, without(start.connected, c));
    for (std::size_t v = 0; v < state.own[c].size(); ++v) {
      const auto& t = state.instant[c][v];
      if (!t) continue;
      const auto motion = motion_to(state, *t, state.view_time[c][v] + offsets[c], of_others);
      state.poses.links[c][v].motion = motion.value_or(Pose());
      if (!motion) unknown.emplace_back(c, v);
    }
  }
  return unknown;
}

// The offsets of the cameras' clocks by whole instants, as `start` has them.
std::vector<double> whole_offsets(const RigState& state, const RigStart& start) {
  std::vector<double> offsets(state.cameras.size(), 0);
  for (const InstantShift& shift : start.shifts) offsets[shift.camera] = shift.instants * state.gap;
  return offsets;
}

// The clocks against that of the reference, from offsets near by (of all cameras).
std::vector<ClockFit> fit_clocks(const RigState& state, const RigStart& start,
                                 const std::vector<double>& near_by) {
  Connected reference = start.connected;
  reference.cameras.assign(state.cameras.size(), 0);
  reference.cameras[state.poses.reference] = 1;
  const Trajectory by_reference = trajectory_of(state, reference);
  std::vector<ClockFit> clocks;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!start.has(c) || c == state.poses.reference) continue;
    const bool meets_reference =
        !clues_of_camera(state, c, world_of_instants(state, c, by_reference), reference).empty();
    const Connected rest = meets_reference ? reference : without(start.connected, c);
    const Trajectory trajectory = meets_reference ? by_reference : trajectory_of(state, rest);
    const auto shift = std::ranges::find(start.shifts, c, &InstantShift::camera);
    const Pose& place =
        shift == start.shifts.end() ? state.poses.camera_from_rig[c] : shift->camera_from_rig;
    if (const auto clock = fit_clock(state, c, trajectory, rest, place, near_by[c]))
      clocks.push_back(*clock);
  }
  return clocks;
}

// Those that are off; with three cameras or more, against the median clock.
std::vector<ClockOffset> clocks_off(const RigState& state, const std::vector<ClockFit>& fits) {
  std::vector<ClockOffset> off;
  std::vector<double> offsets = {0};  // that of the reference
  for (const ClockFit& fit : fits) {
    offsets.push_back(fit.is_off ? fit.clock.offset : 0);
    if (fit.is_off) off.push_back(fit.clock);
  }
  const double middle = median(offsets);
  if (off.empty() || offsets.size() < 3 || middle == 0) return off;
  // Most clocks agree with one another: the reference is off.
  ClockOffset reference = off.front();
  reference.camera = state.poses.reference;
  reference.offset = -middle;
  return {reference};
}

// Finds the clocks near the given offsets, and moves the world of each view from its instant to the
// time of the view by its clock, as the other cameras saw it move. `all`: also by offsets that are
// not off. Sets `offsets` to those that were taken. Views at times that the others do not tell are
// taken out of their instants.
std::vector<ClockFit> correct_clocks(RigState& state, RigStart& start, std::vector<double>& offsets,
                                     bool all) {
  constexpr int kRounds = 3;  // numeric: the trajectory is that of the corrected views after two
  std::vector<ClockFit> clocks;
  for (int round = 0; round < kRounds; ++round) {
    clocks = fit_clocks(state, start, offsets);
    offsets.assign(state.cameras.size(), 0);
    for (const ClockFit& fit : clocks) {
      if (all || fit.is_off) offsets[fit.clock.camera] = fit.clock.offset;
      state.poses.camera_from_rig[fit.clock.camera] = fit.camera_from_rig;
    }
    move_views(state, start, offsets);
    start = start_rig(state, {});
  }
  for (const auto& [camera, view] : move_views(state, start, offsets))
    state.set_alone(camera, view);
  return clocks;
}

}  // namespace

void take_first_bundle(RigState& state, const RigOptions& options) {
  RigState first = state;
  solve_robustly(first, options.calibrate.front());
  update_own_poses(first);
  state.cameras = std::move(first.cameras);
  state.own = std::move(first.own);
  state.poses.camera_from_rig = std::move(first.poses.camera_from_rig);
  state.poses.world_from_board = std::move(first.poses.world_from_board);
  std::copy_n(first.poses.rig_from_world.begin(), state.poses.rig_from_world.size(),
              state.poses.rig_from_world.begin());
}

std::vector<ClockFit> correct_clocks_and_lenses(const RigOptions& options, RigState& state,
                                                RigStart& start) {
  std::vector<double> offsets = whole_offsets(state, start);
  correct_clocks(state, start, offsets, options.find_clocks);
  take_first_bundle(state, options);
  return correct_clocks(state, start, offsets, options.find_clocks);
}

std::vector<ClockOffset> find_clocks_off(const RigOptions& options, const RigState& state,
                                         const RigStart& start) {
  const auto fits = fit_clocks(state, start, whole_offsets(state, start));
  if (start.shifts.empty() && std::ranges::none_of(fits, &ClockFit::is_off)) return {};
  RigState corrected = state;
  RigStart placed = start;
  return clocks_off(state, correct_clocks_and_lenses(options, corrected, placed));
}

}  // namespace tagcal::internal
