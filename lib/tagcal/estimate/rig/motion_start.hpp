#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {

// A camera's view of a board, and the place of the world in the rig at that time.
struct MotionPair {
  Pose camera_from_board;
  Pose rig_from_world;
};

// The places of a camera and of a board that only that camera sees, from the motions of both:
//   camera_from_board = camera_from_rig * rig_from_world * world_from_board.
// Rotation: the rotation vectors of the motions between two instants are those of each other,
// turned (Park & Martin, IEEE Trans. Robotics and Automation 1994); translations by linear least
// squares, the shortest ones if the rotations have one axis. No value for fewer than three views,
// or without rotation.
struct MotionStart {
  Pose camera_from_rig, world_from_board;
};
std::optional<MotionStart> motion_start(std::span<const MotionPair> views);

// One start, or, if all rotations have nearly one axis, those that are turned about it by equal
// steps, from which motion_start takes that of the least residuals of the translations.
std::vector<MotionStart> motion_starts(std::span<const MotionPair> views);

}  // namespace tagcal::internal
