#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The one flat board of a data set, for two-parameter bending: a point at (x, y) of the board moves
// out of its plane by bend.x (1 - x'^2) + bend.y (1 - y'^2), x' and y' from -1 to 1 over the board
// (after mrcal's calobject_warp).
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();

  Eigen::Vector2d shape(const Eigen::Vector3d& x_in_board) const;  // (1 - x'^2, 1 - y'^2)
  std::vector<Eigen::Vector2d> shapes(std::span<const Eigen::Vector3d> x_in_world) const;
  Eigen::Vector3d normal_in_world() const;  // towards the viewer
};

// No value for several boards, or one with thickness or without extent.
std::optional<FlatBoard> flat_board(const Dataset& dataset);

}  // namespace tagcal::internal
