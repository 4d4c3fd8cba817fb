#pragma once

#include <optional>

#include "tagcal/detect/checker_search/checker_print.hpp"
#include "tagcal/detect/checker_search/junction_grid.hpp"

// Private to detect: the junctions of a grid numbered as the corners of a board.
namespace tagcal::internal {

// One of the four ways in which a grid may be numbered: directions of the board's x and y in it.
struct GridNumbering {
  GridCell x, y;
  GridCell origin;  // the junction of the first corner

  GridCell junction(const CheckerCell& corner) const {
    return {origin.first + corner.first * x.first + corner.second * y.first,
            origin.second + corner.first * x.second + corner.second * y.second};
  }

  // Colour of the square to the lower left of the first corner.
  bool starts_black() const {
    const int across = -(x.first + y.first), down = -(x.second + y.second);
    const bool is_white_towards_both = (origin.first + origin.second) % 2 == 0;
    return is_white_towards_both != (across * down > 0);
  }
};

// Columns and rows.
CheckerCell size_of(const JunctionGrid& grid);

// The numbering whose colours are the board's; of several the one whose y points up in the picture.
std::optional<GridNumbering> numbering_of(const JunctionGrid& grid, const CheckerPrint& print);

// True if the grid has the board's number of columns and rows, perhaps turned.
bool is_of_size(const JunctionGrid& grid, const CheckerPrint& print);

}  // namespace tagcal::internal
