#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/rig/rig_state.hpp"

namespace tagcal::internal {

// The disagreement of a camera's own pose with the rig at one instant.
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

// Where the world is at an instant, by one camera.
struct Sight {
  Pose rig_from_world;
  Matrix6 covariance = Matrix6::Zero();
};
using Trajectory = std::vector<std::optional<Sight>>;  // by instant

// The trajectory by the cameras that are connected: at each instant by the one of the least
// uncertainty.
Trajectory trajectory_of(const RigState& state, const std::vector<std::uint8_t>& is_connected);

// The disagreements of a camera with a trajectory, for a place of the camera.
std::vector<Disagreement> disagreements(const RigState& state, std::size_t camera,
                                        const Pose& camera_from_rig, const Trajectory& trajectory);

// The place of a camera by the least median of squares of the disagreements, over the places by
// single instants (Rousseeuw 1984). `half_turn`: the own poses may be turned, and `turned` says
// which ones agree better so. `shift`: the trajectory is taken that many instants later.
struct CameraStart {
  Pose camera_from_rig;
  double median_square = 0;         // of the disagreements
  std::vector<std::size_t> turned;  // views of the camera's bundle
};
std::optional<CameraStart> camera_start(const RigState& state, std::size_t camera,
                                        const Trajectory& trajectory,
                                        const std::optional<Pose>& half_turn, int shift = 0);

// The number of instants at which both cameras have a view.
int common_instants(const RigState& state, std::size_t a, std::size_t b);

// The groups of cameras that common instants connect, that of the reference first.
std::vector<std::vector<std::size_t>> connected_groups(const RigState& state);

// A camera whose pictures fit the trajectory of the others better a number of instants later.
struct InstantShift {
  std::size_t camera = 0;
  int instants = 0;
};

// Sets the poses of the cameras in the group of the reference, and of the instants: along the tree
// of the most common instants, each camera by `camera_start`. Turns the views whose corners have
// the other order. Views that no other camera has at their instant stay at their own pose.
struct RigStart {
  std::vector<std::uint8_t> is_connected;
  std::vector<std::pair<std::size_t, std::size_t>> turned;  // camera and view
  std::vector<InstantShift> shifts;
};
RigStart start_rig(RigState& state, const std::optional<Pose>& half_turn);

}  // namespace tagcal::internal
