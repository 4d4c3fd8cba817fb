#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "tagcal/scene/board.hpp"
#include "tagcal/scene/print/black_squares.hpp"

namespace tagcal::internal {

// A flat part of a board: what is printed on one sheet of paper. A checkerboard is one panel, and
// so is a board whose tags lie in one plane and face the same way; on any other (a cube of tags,
// say) each tag is a panel of its own.
struct BoardPanel {
  Rectangle paper;
  std::vector<Tag> tags;            // of a ChArUco board the markers
  std::vector<Rectangle> squares;   // black_squares
  std::vector<TargetPoint> points;  // that can be observed on it
};

// A convex polygon in the board frame, counter-clockwise seen from its front.
using InkCell = std::vector<Eigen::Vector3d>;

// The panels of a board; a board of measured points has none. The paper is the bounding rectangle
// of tags, discs and squares, white squares included, grown by the margin; tags with cells outside
// of their corners (tagStandard41h12 and its kin) count with those cells.
std::vector<BoardPanel> board_panels(const Board& board, double margin_m);

// The black area of a panel as disjoint polygons: rectangles, and discs as regular polygons of the
// disc's area whose sides lie within 6e-5 radii of the circle. The border width of the
// family is replaced by that of the board; boards without tags need no family. `spread_m` moves
// every edge of the print into the white, a negative one into the black; corners stay right angles.
// Black squares that touch at a corner grow together there, or draw apart. Throws Error if a tag's
// id is not in the family, the family does not allow the board's border or corner squares, or edges
// would meet: |spread_m| must be less than half a cell and half the gap between tags, and less than
// half a square and half the gap between square and marker, or than the radius of a disc and half
// the gap between discs.
std::vector<InkCell> ink_cells(const Board& board, const BoardPanel& panel, const TagFamily& family,
                               double spread_m = 0);

// The ids of two tags in one plane, squares `outer` of their size wider on each side, that overlap
// or touch when every side moves outwards by `spread_m`.
std::optional<std::pair<int, int>> overlapping_tags(const std::vector<Tag>& tags, double outer,
                                                    double spread_m);

// The same for what a flat board prints; tags may touch, as within a micrometre.
std::optional<std::pair<int, int>> overlapping_tags(const Board& board);

// The same for all panels of a board.
std::vector<InkCell> ink_cells(const Board& board, const TagFamily& family);

// What a drawing shows of a panel's print: whole tags, the squares of a checkerboard, and discs
// with fewer corners than those of ink_cells().
std::vector<InkCell> drawn_print(const Board& board, const BoardPanel& panel);

}  // namespace tagcal::internal
