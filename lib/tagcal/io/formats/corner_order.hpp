#pragma once

#include <string>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The corners of a board in the order of other programs' lists: those of a checkerboard row by row
// from the upper left (ids go row by row from the lower left), those of a `points` target by id.
// Throws Error, beginning with `where`, unless there is one board, of these two kinds.
std::vector<CornerId> listed_corners(const std::vector<PlacedBoard>& boards,
                                     const std::string& where);

// Name of a view in a list that has none: view0000, ..
std::string view_name(std::size_t index);

}  // namespace tagcal::internal
