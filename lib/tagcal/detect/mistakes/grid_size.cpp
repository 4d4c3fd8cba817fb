#include "tagcal/detect/mistakes/grid_size.hpp"

#include <fmt/format.h>

namespace tagcal::internal {

std::optional<TargetMistake> grid_size_mistake(const SeenChecker& seen, const Board& board) {
  if (seen.answer != CheckerAnswer::other_grid) return std::nullopt;
  const Checkerboard squares = checkers(board).value();
  const auto [columns, rows] = size_beside(seen.size, squares);
  TargetMistake mistake{"wrong size of grid", "", true};
  if (columns == squares.columns - 1 && rows == squares.rows - 1) {
    mistake.sentence = fmt::format(
        "the picture shows a grid of {} x {} corners, as a board of {} x {} squares has; the "
        "target "
        "file must count the corners inside, not the squares; write targetCols: {}, targetRows: {}",
        columns, rows, squares.columns, squares.rows, columns, rows);
    return mistake;
  }
  mistake.needs_others = columns <= squares.columns && rows <= squares.rows;
  mistake.sentence = fmt::format(
      "the picture shows a grid of {} x {} corners, but the target file says {} x {}; write "
      "targetCols: {}, targetRows: {}",
      columns, rows, squares.columns, squares.rows, columns, rows);
  return mistake;
}

}  // namespace tagcal::internal
