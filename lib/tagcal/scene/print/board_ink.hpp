#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "tagcal/scene/board.hpp"

namespace tagcal::internal {

// A rectangle in the board frame (metres), corners as those of a tag: lower-left, lower-right,
// upper-right, upper-left seen from its front.
using Rectangle = std::array<Eigen::Vector3d, 4>;

// A flat part of a board: tags on one sheet of paper. A board whose tags lie in one plane and face
// the same way is one panel; on any other (a cube of tags, say) each tag is a panel of its own.
struct BoardPanel {
  Rectangle paper;
  std::vector<Tag> tags;
  std::vector<Rectangle> corner_squares;  // Kalibr's, black
};

// The panels of a board; a board of points has none. The paper is the bounding rectangle of tags
// and corner squares, grown by the margin; tags with cells outside of their corners
// (tagStandard41h12 and its kin) count with those cells.
std::vector<BoardPanel> board_panels(const Board& board, double margin_m);

// The black area of a panel as disjoint rectangles in the board frame. The border width of the
// family is replaced by that of the board. `spread_m` moves every edge of the print into the white,
// a negative one into the black; corners stay right angles. Throws Error if a tag's id is not in
// the family, the family does not allow the board's border or corner squares, or edges would meet:
// |spread_m| must be less than half a cell and half the gap between tags.
std::vector<Rectangle> ink_cells(const Board& board, const BoardPanel& panel,
                                 const TagFamily& family, double spread_m = 0);

// The same for all panels of a board.
std::vector<Rectangle> ink_cells(const Board& board, const TagFamily& family);

}  // namespace tagcal::internal
