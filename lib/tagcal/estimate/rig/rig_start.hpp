#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/rig/rig_state.hpp"

namespace tagcal::internal {

// Which cameras and boards have a place that is known relative to the reference.
struct Connected {
  std::vector<std::uint8_t> cameras, boards;
};

// Where the world is at an instant.
struct Sight {
  Pose rig_from_world;
  Matrix6 covariance = Matrix6::Zero();  // of (omega, tau): `retract`
};
using Trajectory = std::vector<std::optional<Sight>>;  // by instant

// The trajectory by the connected cameras that see connected boards: at each instant by the view of
// the least uncertainty.
Trajectory trajectory_of(const RigState& state, const Connected& connected);

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

// The disagreements of a camera's views of connected boards with a trajectory, for a place of the
// camera.
std::vector<Disagreement> disagreements(const RigState& state, std::size_t camera,
                                        const Pose& camera_from_rig, const Trajectory& trajectory,
                                        const Connected& connected);

// The place of a camera by the least median of squares of the disagreements, over the places by
// single views (Rousseeuw 1984). `half_turn`: the own poses may be turned, and `turned` says which
// ones agree better so. `shift`: the trajectory is taken that many instants later.
struct PlaceStart {
  Pose place;                       // camera_from_rig, or world_from_board
  double median_square = 0;         // of the disagreements
  std::vector<std::size_t> turned;  // views of the camera's bundle
};
std::optional<PlaceStart> camera_start(const RigState& state, std::size_t camera,
                                       const Trajectory& trajectory, const Connected& connected,
                                       const std::optional<Pose>& half_turn, int shift = 0);

// The number of instants at which both cameras have a view.
int common_instants(const RigState& state, std::size_t a, std::size_t b);

// A camera whose pictures fit the trajectory of the others better a number of instants later.
struct InstantShift {
  std::size_t camera = 0;
  int instants = 0;
};

// Sets the poses of the cameras, boards and instants that are connected with the reference, one
// after the other, each by the most views: a camera or a board by the least median of squares;
// where no view has a known camera or a known board, both by the motions of the camera and of the
// rest (motion_start). Turns the views whose corners have the other order. The first board is that
// which the reference sees most.
struct RigStart {
  Connected connected;
  std::vector<std::pair<std::size_t, std::size_t>> turned;  // camera and view
  std::vector<InstantShift> shifts;

  bool has(std::size_t camera) const { return connected.cameras[camera]; }
};
RigStart start_rig(RigState& state, const std::optional<Pose>& half_turn);

// The groups of cameras that are connected: that of the reference first, then by common instants.
std::vector<std::vector<std::size_t>> groups_of(const RigState& state, const RigStart& start);

}  // namespace tagcal::internal
