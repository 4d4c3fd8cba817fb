#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "tagcal/scene/board.hpp"

namespace tagcal::internal {

// The family with the black border of the board. Throws Error if the family does not allow this
// border or the board's corner squares. Precondition: the board has tags.
TagFamily with_border(TagFamily family, const Board& board);

// The cells of a tag, row by row from above; 1 is black (as apriltag_to_image in AprilTag 3 draws
// it: a white ring outside of a black border, or the outermost ring inside of a reversed one).
struct PrintedTag {
  std::vector<double> lines;  // between the cells, from the left as from above; width + 1
  std::vector<char> black;

  explicit PrintedTag(std::vector<double> between, char everywhere)
      : lines(std::move(between)),
        black(static_cast<std::size_t>(width()) * static_cast<std::size_t>(width()), everywhere) {}

  int width() const { return static_cast<int>(lines.size()) - 1; }
  char& at(int x, int y) { return black[static_cast<std::size_t>(y * width() + x)]; }
  bool is_black(int x, int y) const {
    if (std::min(x, y) < 0 || std::max(x, y) >= width()) return false;
    return black[static_cast<std::size_t>(y * width() + x)] != 0;
  }
  bool all_black(int x0, int x1, int y) const {
    for (int x = x0; x < x1; ++x)
      if (!is_black(x, y)) return false;
    return true;
  }
};

// True if the family determines the colour of a cell, counted from the border's upper-left one. Of
// a family with a reversed border these are the bits, the white ring and the black ring around it.
// The other cells are up to the print: the middle of tagCustom48h12, and what is outside of a
// circle.
bool is_determined(const TagFamily& family, int x, int y);

// Throws Error for an id that the family does not have.
void check_tag_id(const TagFamily& family, int id);

// The cells of a whole tag; lines are 0, 1, .. total_width. Throws Error for an unknown id.
PrintedTag printed_tag(const TagFamily& family, int id);

// The tag with every black edge moved into the white by `spread` cells, between -0.5 and 0.5
// (negative: into the black).
PrintedTag spread_out(const PrintedTag& tag, double spread);

}  // namespace tagcal::internal
