#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/rig/rig_sight.hpp"

namespace tagcal::internal {

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

// A camera whose pictures fit the trajectory of the others better a number of instants later, and
// its place then.
struct InstantShift {
  std::size_t camera = 0;
  int instants = 0;
  Pose camera_from_rig;
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
