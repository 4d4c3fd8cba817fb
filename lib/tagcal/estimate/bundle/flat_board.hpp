#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The displacements of a view's points by a unit of each bend, and their direction.
struct BoardShapes {
  std::vector<Eigen::Vector2d> of_points;  // empty without a bend
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();

  ViewBend view() const { return {of_points, normal}; }
};

// The flat board of a data set with one board, for a bend of two parameters: a point at (x, y)
// moves out of the plane by bend.x (1 - x'^2) + bend.y (1 - y'^2), with x' and y' from -1 to 1 over
// the board (after mrcal's calobject_warp).
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     // board frame, metres
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();  // metres

  // The same for a flat and for a bent board, because a bend does not move points in the plane.
  BoardShapes shapes(std::span<const Eigen::Vector3d> x_in_world) const;
  void bend(ViewProblem& view, const Eigen::Vector2d& by_m) const;  // moves the view's points
};

// No value if there are several boards, or if the board has thickness or no extent.
std::optional<FlatBoard> flat_board(const Dataset& dataset);

}  // namespace tagcal::internal
