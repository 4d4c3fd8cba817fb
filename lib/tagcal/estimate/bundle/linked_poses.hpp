#pragma once

#include <cstddef>
#include <vector>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {

// The poses of the views of cameras on one body, before boards that are rigid in one world:
//   camera_from_board = camera_from_rig[camera] * motion * rig_from_world[instant] *
//                       world_from_board[board].
// A single camera is such a body: its frame is that of the rig, and each view is an instant.
struct LinkedPoses {
  struct Link {
    std::size_t instant = 0;
    std::size_t board = 0;
    // Moves the world in the rig from the instant to the time of the view, if they differ; held.
    Pose motion = {};
  };

  std::vector<Pose> camera_from_rig;   // that of the reference camera is held
  std::vector<Pose> rig_from_world;    // by instant
  std::vector<Pose> world_from_board;  // that of `first_board` is held
  std::size_t reference = 0;
  std::size_t first_board = 0;
  std::vector<std::vector<Link>> links;  // by camera, and view of its bundle

  Pose camera_from_board(std::size_t camera, const Link& link) const {
    return camera_from_rig[camera] * link.motion * rig_from_world[link.instant] *
           world_from_board[link.board];
  }
};

// The step (`retract`) of a pose A B C by that of B, with A's rotation and C's translation in
// the target frame of B, less that of B: the point that a rotation of B moves.
Matrix6 step_by(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& arm);

// The steps (`retract`) of a view's pose by those of its three parts, to first order. The rotations
// of a part's frame turn the steps of those to its right.
struct LinkedSteps {
  Matrix6 by_camera, by_instant, by_board;

  LinkedSteps(const LinkedPoses& poses, std::size_t camera, const LinkedPoses::Link& link);
};

}  // namespace tagcal::internal
