#include "tagcal/scene/print/printed_tag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tagcal/error.hpp"
#include "tagcal/internal/overloaded.hpp"

namespace tagcal::internal {

TagFamily with_border(TagFamily family, const Board& board) {
  if (family.reversed_border) {
    const bool has_squares =
        std::visit(Overloaded{[](const AprilGrid& grid) { return grid.corner_squares; },
                              [](const auto&) { return false; }},
                   board.pattern);
    if (!has_squares) return family;
    throw Error(fmt::format("board: corner_squares: {} cannot have them, its border is not black",
                            family.name));
  }
  int border_bits = family.width_at_border;
  for (const TagFamily::Cell& bit : family.bits) border_bits = std::min(border_bits, bit.x);
  const int wanted_bits = tag_kind(board)->border_bits;
  if (wanted_bits < 1 || border_bits < 1)
    throw Error(fmt::format("board: border_bits: {} cannot have {}", family.name, wanted_bits));
  const int more = wanted_bits - border_bits;
  family.width_at_border += 2 * more;
  family.total_width += 2 * more;
  for (TagFamily::Cell& bit : family.bits) {
    bit.x += more;
    bit.y += more;
  }
  return family;
}

bool is_determined(const TagFamily& family, int x, int y) {
  const auto is_in_ring = [&](int first) {
    const int last = family.width_at_border - 1 - first;
    const auto [low, high] = std::minmax(x, y);
    return low >= first && high <= last && (low == first || high == last);
  };
  return !family.reversed_border || is_in_ring(0) || is_in_ring(-1) ||
         std::ranges::any_of(family.bits,
                             [&](const TagFamily::Cell& bit) { return bit.x == x && bit.y == y; });
}

void check_tag_id(const TagFamily& family, int id) {
  if (id < 0 || static_cast<std::size_t>(id) >= family.codes.size())
    throw Error(fmt::format("board: tag id: must be in 0..{} of {}, got {}",
                            family.codes.size() - 1, family.name, id));
}

PrintedTag printed_tag(const TagFamily& family, int id) {
  check_tag_id(family, id);
  const int n = family.total_width;
  std::vector<double> lines(static_cast<std::size_t>(n) + 1);
  std::iota(lines.begin(), lines.end(), 0.0);
  PrintedTag result(std::move(lines), 1);
  const int border_start = (n - family.width_at_border) / 2;
  const int ring = border_start - (family.reversed_border ? 0 : 1);
  for (int i = ring; i < n - ring; ++i)
    result.at(i, ring) = result.at(ring, i) = result.at(i, n - 1 - ring) =
        result.at(n - 1 - ring, i) = 0;
  const std::uint64_t code = family.codes[static_cast<std::size_t>(id)];
  const std::size_t num_bits = family.bits.size();
  for (std::size_t i = 0; i < num_bits; ++i) {
    const bool white = (code >> (num_bits - 1 - i) & 1) != 0;
    if (white) result.at(family.bits[i].x + border_start, family.bits[i].y + border_start) = 0;
  }
  return result;
}

// Divides every cell, and a ring of white ones around the tag, into a middle and strips along its
// sides. The colour of a strip also depends on the cells beyond that side.
PrintedTag spread_out(const PrintedTag& tag, double spread) {
  if (spread == 0) return tag;
  std::vector<double> lines;
  for (int cell = -1; cell <= tag.width(); ++cell)
    for (const double line : {0.0, std::abs(spread), 1 - std::abs(spread)})
      lines.push_back(cell + line);
  lines.push_back(tag.width() + 1);
  PrintedTag result(std::move(lines), 0);
  for (int y = 0; y < result.width(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      const int cell_x = x / 3 - 1, beyond_x = cell_x + x % 3 - 1;
      const int cell_y = y / 3 - 1, beyond_y = cell_y + y % 3 - 1;
      const int num_black = tag.is_black(cell_x, cell_y) + tag.is_black(beyond_x, cell_y) +
                            tag.is_black(cell_x, beyond_y) + tag.is_black(beyond_x, beyond_y);
      result.at(x, y) = spread > 0 ? num_black > 0 : num_black == 4;
    }
  }
  return result;
}

}  // namespace tagcal::internal
