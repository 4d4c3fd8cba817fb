#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The flat board of a data set with one board, for a bend of two parameters: a point at (x, y)
// moves out of the plane by bend.x (1 - x'^2) + bend.y (1 - y'^2), with x' and y' from -1 to 1 over
// the board (after mrcal's calobject_warp).
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     // board frame, metres
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();  // metres

  Eigen::Vector2d shape(const Eigen::Vector3d& x_in_board) const;  // (1 - x'^2, 1 - y'^2)
  std::vector<Eigen::Vector2d> shapes(std::span<const Eigen::Vector3d> x_in_world) const;
  Eigen::Vector3d normal_in_world() const;  // towards the viewer
};

// No value if there are several boards, or if the board has thickness or no extent.
std::optional<FlatBoard> flat_board(const Dataset& dataset);

}  // namespace tagcal::internal
