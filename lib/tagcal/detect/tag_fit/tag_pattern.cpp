#include <algorithm>
#include <cmath>

#include "tagcal/detect/refine.hpp"
#include "tagcal/scene/print/printed_tag.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal {
using namespace internal;
namespace {

bool covers(const InkCell& rectangle, double x, double y) {
  return rectangle[0].x() < x && x < rectangle[2].x() && rectangle[0].y() < y &&
         y < rectangle[2].y();
}

}  // namespace

TagPattern tag_pattern(const TagFamily& family, int id, int border_bits,
                       const TagSurroundings& surroundings) {
  // Drawn as a board of one tag, so that the pattern cannot differ from the renderer's.
  const bool has_squares = surroundings.corner_squares && surroundings.gap > 0;
  const Board board =
      make_board(AprilGrid{1, 1, 1.0, surroundings.gap, id, family.name, border_bits, has_squares});
  const std::vector<InkCell> ink = ink_cells(board, family);

  const TagFamily printed = with_border(family, board);
  const int side = printed.width_at_border;
  // Kalibr's squares stand where other tags have their white frame.
  const int frame = has_squares ? 0 : (printed.total_width - side) / 2;
  TagPattern pattern;
  for (int i = -frame; i <= side + frame; ++i)
    pattern.lines.push_back(static_cast<double>(i) / side);
  if (surroundings.gap > static_cast<double>(frame) / side) {
    pattern.lines.insert(pattern.lines.begin(), -surroundings.gap);
    pattern.lines.push_back(1 + surroundings.gap);
  }
  const std::vector<double>& lines = pattern.lines;
  for (std::size_t row = 0; row + 1 < lines.size(); ++row) {
    for (std::size_t column = 0; column + 1 < lines.size(); ++column) {
      const double x = (lines[column] + lines[column + 1]) / 2;
      const double y = 1 - (lines[row] + lines[row + 1]) / 2;  // the board's y points up
      const bool is_black = std::ranges::any_of(
          ink, [&](const InkCell& rectangle) { return covers(rectangle, x, y); });
      const bool is_corner = (x < 0 || x > 1) && (y < 0 || y > 1);
      const auto cell = [&](double at) { return static_cast<int>(std::floor(at * side)); };
      const bool is_free = !is_determined(family, cell(x), cell(1 - y));
      pattern.cells.push_back(is_free || (is_corner && surroundings.corner_squares && !has_squares)
                                  ? TagPattern::unknown
                              : is_black ? TagPattern::black
                                         : TagPattern::white);
    }
  }
  return pattern;
}

}  // namespace tagcal
