#pragma once

#include <map>
#include <vector>

#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal {

// What a board says of the surroundings of its tags. Without squares, what is beside the outer tags
// is not known.
TagSurroundings surroundings_on(const Board& board);

// The patterns of all tags of the boards, by id. Throws Error as tag_family() and tag_pattern() do.
std::map<int, TagPattern> board_patterns(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal
