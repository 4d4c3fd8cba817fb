#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "tagcal/estimate/rig/rig_state.hpp"

// The places of a rig's cameras and boards by single views.

namespace tagcal::internal {

// Which cameras and boards have a place that is known relative to the reference.
struct Connected {
  std::vector<std::uint8_t> cameras, boards;
};
Connected without(Connected connected, std::size_t camera);

// The place of the world in the rig at an instant.
struct Sight {
  Pose rig_from_world;
  Matrix6 covariance = Matrix6::Zero();  // of (omega, tau): `retract`
};
using Trajectory = std::vector<std::optional<Sight>>;  // by instant

// The trajectory by the connected cameras that see connected boards: at each instant by the view of
// the least uncertainty.
Trajectory trajectory_of(const RigState& state, const Connected& connected);

// The world in the rig at a time between instants, and its motion there (as a step of `retract` in
// the unit of RigState::time): by the polynomial through three to six neighbouring instants, at
// most three on a side, that follow one another without one that has no sight, or a gap longer than
// policy::kLongestGap. No value with less than three, or outside of them.
struct MovingSight {
  Sight sight;
  Vector6d velocity;
};
std::optional<MovingSight> world_at(const RigState& state, double time,
                                    const Trajectory& trajectory);

// The disagreement of a view's own pose with the rig.
struct Disagreement {
  std::size_t instant = 0;
  std::size_t view = 0;  // of the camera's bundle
  // From the own pose to that which the rig predicts (`minus`), and its covariance by the noise of
  // the corners alone.
  Vector6d step = Vector6d::Zero();
  Matrix6 covariance = Matrix6::Zero();

  // step' covariance^-1 step: chi-square of six degrees of freedom.
  double square() const;
};

// The world at a view of one camera, if it is known.
using WorldOfView = std::function<std::optional<Sight>(std::size_t view)>;

// That of the instants of the views, which is kept as a reference; `shift`: of instants that many
// later.
WorldOfView world_of_instants(const RigState& state, std::size_t camera,
                              const Trajectory& trajectory, int shift = 0);

// The disagreements of a camera's views of connected boards with the world at them, for a place of
// the camera.
std::vector<Disagreement> disagreements(const RigState& state, std::size_t camera,
                                        const Pose& camera_from_rig, const WorldOfView& world,
                                        const Connected& connected);

// A view that tells a place U: its own pose is `left` U `right`, up to its noise and that of the
// trajectory, which is given as of `right`, or of the whole.
struct Clue {
  std::size_t camera, view, instant;
  Pose left, right;
  Matrix6 of_right = Matrix6::Zero(), of_whole = Matrix6::Zero();
};

// The views of a camera of connected boards.
std::vector<Clue> clues_of_camera(const RigState& state, std::size_t camera,
                                  const WorldOfView& world, const Connected& connected);

// The views of a board by connected cameras.
std::vector<Clue> clues_of_board(const RigState& state, std::size_t board,
                                 const Trajectory& trajectory, const Connected& connected);

// The world in the rig, by a view's own pose and the places of its camera and board.
Pose world_by_view(const RigState& state, std::size_t camera, std::size_t view);

// The disagreement of a view with a place, for one of its own poses.
Disagreement disagreement_of(const RigState& state, const Clue& clue, const Pose& own_pose,
                             const Pose& place);

}  // namespace tagcal::internal
