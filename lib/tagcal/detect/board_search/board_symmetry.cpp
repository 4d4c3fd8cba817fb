#include "tagcal/detect/board_search/board_symmetry.hpp"

#include <fmt/format.h>

#include "tagcal/internal/overloaded.hpp"

namespace tagcal::internal {
namespace {

// A board that looks the same after `turn`, with what to use instead; `turn` is empty if it looks
// different after every turn.
struct Symmetry {
  std::string board, turn, instead;
};

Symmetry symmetry_of(const Checkerboard& board) {
  if ((board.columns + board.rows) % 2 != 0) return {};
  const bool is_square = board.columns == board.rows && board.columns % 2 == 0;
  return {fmt::format("the checkerboard of {} x {} corners", board.columns, board.rows),
          is_square ? "a quarter turn" : "half a turn",
          "a board with an odd number of squares in one direction and an even number in the other"};
}

Symmetry symmetry_of(const CircleGrid& grid) {
  if (grid.asymmetric && grid.rows % 2 != 0) return {};
  const bool is_square = !grid.asymmetric && grid.columns == grid.rows;
  return {name_of(grid), is_square ? "a quarter turn" : "half a turn",
          "an asymmetric grid with an odd number of rows"};
}

}  // namespace

std::string name_of(const CircleGrid& grid) {
  return fmt::format("the {} grid of {} x {} circles", grid.asymmetric ? "asymmetric" : "symmetric",
                     grid.columns, grid.rows);
}

std::vector<std::string> symmetry_warnings(const std::vector<PlacedBoard>& boards) {
  std::vector<std::string> warnings;
  for (const PlacedBoard& placed : boards) {
    const Symmetry symmetry =
        std::visit(Overloaded{[](const Checkerboard& squares) { return symmetry_of(squares); },
                              [](const CircleGrid& circles) { return symmetry_of(circles); },
                              [](const auto&) { return Symmetry{}; }},
                   placed.board.pattern);
    if (symmetry.turn.empty()) continue;
    warnings.push_back(fmt::format(
        "{} looks the same after {}: in each picture its y axis is taken to be the one that points "
        "up most, so a board on its head is numbered from the wrong end. A calibration does not "
        "change, poses do. Use {}",
        symmetry.board, symmetry.turn, symmetry.instead));
  }
  return warnings;
}

}  // namespace tagcal::internal
