#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "tagcal/scene/board.hpp"

namespace tagcal::internal {

// A rectangle in the board frame (metres), corners as those of a tag: lower-left, lower-right,
// upper-right, upper-left seen from its front.
using Rectangle = std::array<Eigen::Vector3d, 4>;

// A box of the plane z = 0 of a frame.
Rectangle rectangle(const Pose& board_from_frame, const Eigen::AlignedBox2d& box);

// The black squares of a checkerboard, or Kalibr's between the tags of a grid; none on other
// boards. Disjoint, and outside of the tags. `spread_m` moves each edge outwards, a negative one
// inwards. What two grown squares that touch at a corner have in common belongs to one of them, and
// what a square has in common with a grown tag to the tag; then a square is several rectangles.
std::vector<Rectangle> black_squares(const Board& board, double spread_m = 0);

// The whole area of a checkerboard, its white squares included, in the board frame.
Eigen::AlignedBox2d checkerboard_area(const Checkerboard& board);

}  // namespace tagcal::internal
