#pragma once

#include <map>
#include <utility>
#include <vector>

#include "tagcal/detect/checker_search/junctions.hpp"

// Private to detect.
namespace tagcal::internal {

// Cell (column, row) of a grid; the columns' direction turned by less than half a turn towards the
// picture's y is that of the rows.
using GridCell = std::pair<int, int>;

// Junctions in a grid. The square towards larger columns and rows of junction (column, row) is
// white if column + row is even.
using JunctionGrid = std::map<GridCell, Eigen::Vector2d>;

// The grids that the junctions form: from pairs of neighbours, each further one is predicted from
// those beside it. Each junction is in one grid at most; a grid has 2 x 2 junctions or more.
// With `follows_lines` also those to which lines of the grid lead where steps change too much to be
// predicted, as in a fisheye's picture of a near board; grids may then share junctions.
std::vector<JunctionGrid> junction_grids(const std::vector<Junction>& junctions,
                                         bool follows_lines);

}  // namespace tagcal::internal
