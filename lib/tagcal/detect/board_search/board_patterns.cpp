#include "tagcal/detect/board_search/board_patterns.hpp"

#include "tagcal/detect/families.hpp"
#include "tagcal/internal/overloaded.hpp"

namespace tagcal::internal {

TagSurroundings tag_surroundings(const Board& board) {
  return std::visit(
      Overloaded{
          [](const AprilGrid& grid) {
            return TagSurroundings{grid.corner_squares ? grid.tag_spacing : 0, grid.corner_squares};
          },
          [](const auto&) { return TagSurroundings{}; }},
      board.pattern);
}

CellSurroundings cell_surroundings(const Board& board, const TagFamily& family) {
  const int cells = family.width_at_border;  // along a side
  return std::visit(
      Overloaded{[&](const AprilGrid& grid) {
                   return CellSurroundings{grid.tag_spacing * cells >= 1, grid.corner_squares};
                 },
                 [&](const Charuco& squares) {
                   const double white = (squares.square_size - squares.marker_size) / 2;
                   return CellSurroundings{white * cells >= squares.marker_size, false};
                 },
                 [](const auto&) { return CellSurroundings{}; }},
      board.pattern);
}

void add_patterns(const Board& board, std::map<int, TagPattern>& patterns) {
  const auto kind = tag_kind(board);
  if (!kind) return;
  const TagSurroundings around = tag_surroundings(board);
  const TagFamily family = tag_family(kind->family, kind->border_bits);
  for (const Tag& tag : tags_of(board))
    if (tag.id < static_cast<int>(family.codes.size()))
      patterns.emplace(tag.id, tag_pattern(family, tag.id, kind->border_bits, around));
}

std::map<int, TagPattern> board_patterns(const std::vector<PlacedBoard>& boards) {
  std::map<int, TagPattern> patterns;
  for (const PlacedBoard& placed : boards) add_patterns(placed.board, patterns);
  return patterns;
}

}  // namespace tagcal::internal
