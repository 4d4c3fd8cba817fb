#pragma once

#include <map>
#include <vector>

#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

// Adds the patterns of a board's tags, by id. Without squares, what is beside the outer tags is not
// known. An id that the family has not has none, and is never seen. Throws Error as tag_family()
// and tag_pattern() do.
void add_patterns(const Board& board, std::map<int, TagPattern>& patterns);

// Those of all boards.
std::map<int, TagPattern> board_patterns(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal::internal
