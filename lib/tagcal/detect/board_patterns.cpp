#include "tagcal/detect/board_patterns.hpp"

#include "tagcal/detect/families.hpp"

namespace tagcal {

TagSurroundings surroundings_on(const Board& board) {
  TagSurroundings around;
  around.corner_squares = board.corner_squares;
  if (board.grid && board.corner_squares) around.gap = board.grid->tag_spacing;
  return around;
}

std::map<int, TagPattern> board_patterns(const std::vector<PlacedBoard>& boards) {
  std::map<int, TagPattern> patterns;
  for (const PlacedBoard& placed : boards) {
    const Board& board = placed.board;
    if (board.tags.empty()) continue;
    const TagFamily family = tag_family(board.family, board.border_bits);
    for (const Tag& tag : board.tags)
      patterns.emplace(tag.id,
                       tag_pattern(family, tag.id, board.border_bits, surroundings_on(board)));
  }
  return patterns;
}

}  // namespace tagcal
