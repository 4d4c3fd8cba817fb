#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/pose/view_equations.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The displacements of a view's points by a unit of each shape of their board, and their
// directions.
struct BoardShapes {
  std::vector<Eigen::Vector4d> of_points;  // empty without a board
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d across = Eigen::Vector3d::Zero();

  ViewShapes view() const { return {of_points, normal, across}; }
};

// How a board differs from its file: a point at (x, y) of the board, with x' and y' from -1 to 1
// over it, is out of its plane by
//   shape[0] (1 - x'^2) + shape[1] (1 - y'^2) + shape[2] x' y'   metres (bends after mrcal, twist)
// and at y (1 + shape[3]) instead of y (print aspect).
using BoardShape = Eigen::Vector4d;

// The standard deviation of the share by which a print is longer along y than along x.
double sigma_of_print(const Tolerance& print);
// The standard deviation of a board's scale, which no picture shows. Lengths along x and along y
// have equal errors: their difference (of the prior, and as found) over root 2.
double sigma_of_scale(double sigma_of_print, double found_aspect = 0);

// The flat board of a data set with one board.
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     // board frame, metres
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();  // metres
  BoardShape prior_sigma = BoardShape::Ones();          // of each shape, about zero
  Substrate substrate;                                  // from which it follows

  BoardShapes shapes(std::span<const Eigen::Vector3d> x_in_world) const;
};

// No value if there are several boards, or if the board has thickness or no extent. Throws Error
// for a substrate out of its range.
std::optional<FlatBoard> flat_board(const Dataset& dataset);

}  // namespace tagcal::internal
