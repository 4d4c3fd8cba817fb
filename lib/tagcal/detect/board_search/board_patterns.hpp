#pragma once

#include <map>
#include <vector>

#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/refine.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

// The print around the tags of a board, for fits and for the comparison of cells.
TagSurroundings tag_surroundings(const Board& board);
CellSurroundings cell_surroundings(const Board& board, const TagFamily& family);

// Adds the patterns of a board's tags, by id. Without corner squares the surroundings of a tag
// beyond its frame are unknown. Ids that the family lacks get no pattern. Throws Error as
// tag_family() and tag_pattern() do.
void add_patterns(const Board& board, std::map<int, TagPattern>& patterns);

// The patterns of all boards.
std::map<int, TagPattern> board_patterns(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal::internal
