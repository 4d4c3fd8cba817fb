#include "tagcal/detect/board_search/board_patterns.hpp"

#include "tagcal/detect/families.hpp"

namespace tagcal::internal {

void add_patterns(const Board& board, std::map<int, TagPattern>& patterns) {
  if (board.tags.empty()) return;
  TagSurroundings around;
  around.corner_squares = board.corner_squares;
  if (board.grid && board.corner_squares) around.gap = board.grid->tag_spacing;
  const TagFamily family = tag_family(board.family, board.border_bits);
  for (const Tag& tag : board.tags)
    if (tag.id < static_cast<int>(family.codes.size()))
      patterns.emplace(tag.id, tag_pattern(family, tag.id, board.border_bits, around));
}

std::map<int, TagPattern> board_patterns(const std::vector<PlacedBoard>& boards) {
  std::map<int, TagPattern> patterns;
  for (const PlacedBoard& placed : boards) add_patterns(placed.board, patterns);
  return patterns;
}

}  // namespace tagcal::internal
