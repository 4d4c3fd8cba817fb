#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/reproject/rows/map_rows.hpp"

namespace tagcal::internal {

// The part of the source that a target pixel covers, as the kernel sees it: round with this width,
// and drawn out along a line of half-length `along` (source pixels). Width 1, along 0: the plain
// kernel.
struct Footprint {
  double width = 1;
  Eigen::Vector2d along = Eigen::Vector2d::Zero();
};

// The Jacobian of a map (source pixels per target pixel) at the nodes of a grid of blocks, linear
// between them.
class Footprints {
 public:
  // One row of blocks: the rows [block_row, block_row + 1) * policy::kBlock of the target.
  // `largest` bounds the width of a footprint in pixels.
  Footprints(const MapRows& rows, int block_row, double largest);

  // True if the plain kernel serves all pixels of the block.
  bool is_plain(int block) const { return plain_[static_cast<std::size_t>(block)] != 0; }

  // True if all footprints of the block are round.
  bool is_round(int block) const { return round_[static_cast<std::size_t>(block)] != 0; }

  Footprint at(int u, int v) const;

  // The width of a footprint in a block whose footprints are round: linear between the nodes.
  double round_width(int u, int v) const;

 private:
  struct Node {
    Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
    bool valid = false;
    Footprint footprint;
  };

  Node node_at(const MapRows& rows, double u, double v) const;

  int first_row_;
  double largest_;
  std::vector<Node> upper_, lower_;  // one more than blocks
  std::vector<char> plain_, round_;
};

}  // namespace tagcal::internal
