#include "tagcal/scene/board_ink.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <string_view>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Cells outside of the corners that the detector reports, per cell between them. Families that are
// not named here have none but a white frame. (The patterns themselves are not known to those who
// only ask what is visible.)
struct OuterCells {
  std::string_view family;
  double cells;
  double width_at_border;
};
constexpr OuterCells kOuterCells[] = {{"tagStandard41h12", 2, 5},
                                      {"tagStandard52h13", 2, 6},
                                      {"tagCircle21h7", 2, 5},
                                      {"tagCircle49h12", 3, 5},
                                      {"tagCustom48h12", 2, 6}};

double outer_share(std::string_view family) {
  const auto* const found = std::ranges::find(kOuterCells, family, &OuterCells::family);
  return found == std::end(kOuterCells) ? 0 : found->cells / found->width_at_border;
}

Rectangle rectangle(const Pose& board_from_frame, const AlignedBox2d& box) {
  using Corner = AlignedBox2d::CornerType;
  Rectangle result;
  const Corner corners[] = {AlignedBox2d::BottomLeft, AlignedBox2d::BottomRight,
                            AlignedBox2d::TopRight, AlignedBox2d::TopLeft};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d corner = box.corner(corners[i]);
    result[i] = board_from_frame * Vector3d(corner.x(), corner.y(), 0);
  }
  return result;
}

Vector3d normal(const Tag& tag) { return tag.board_from_tag.rotation() * Vector3d::UnitZ(); }

bool one_plane(const std::vector<Tag>& tags) {
  const Vector3d n = normal(tags.front());
  const Vector3d& origin = tags.front().board_from_tag.translation();
  return std::ranges::all_of(tags, [&](const Tag& tag) {
    const double height = n.dot(tag.board_from_tag.translation() - origin);
    return (normal(tag) - n).norm() < 1e-9 && std::abs(height) < 1e-9;
  });
}

std::vector<Rectangle> corner_squares(const Board& board) {
  std::vector<Rectangle> squares;
  if (!board.grid || !board.corner_squares || board.grid->tag_spacing == 0) return squares;
  const Grid& grid = *board.grid;
  const double gap = grid.tag_spacing * grid.tag_size;
  const double pitch = grid.tag_size + gap;
  for (int row = 0; row <= grid.rows; ++row) {
    for (int column = 0; column <= grid.columns; ++column) {
      const Vector2d upper_right(column * pitch, row * pitch);
      squares.push_back(
          rectangle(Pose(), AlignedBox2d(upper_right - Vector2d(gap, gap), upper_right)));
    }
  }
  return squares;
}

BoardPanel make_panel(const Board& board, std::vector<Tag> tags, std::vector<Rectangle> squares,
                      double margin_m) {
  const bool upright = (normal(tags.front()) - Vector3d::UnitZ()).norm() < 1e-9 && tags.size() > 1;
  const Pose& tag_pose = tags.front().board_from_tag;
  const Pose board_from_sheet(upright ? Eigen::Quaterniond::Identity() : tag_pose.rotation(),
                              tag_pose.translation());
  const Pose sheet_from_board = board_from_sheet.inverse();
  AlignedBox2d box;
  for (Tag tag : tags) {
    tag.size *= 1 + 2 * outer_share(board.family);
    for (const Vector3d& corner : tag_corners(tag))
      box.extend((sheet_from_board * corner).head<2>());
  }
  for (const Rectangle& square : squares)
    for (const Vector3d& corner : square) box.extend((sheet_from_board * corner).head<2>());
  box.min().array() -= margin_m;
  box.max().array() += margin_m;
  return {rectangle(board_from_sheet, box), std::move(tags), std::move(squares)};
}

TagFamily with_border(TagFamily family, const Board& board) {
  if (family.reversed_border) {
    if (!board.corner_squares || !board.grid) return family;
    throw Error(fmt::format("board: corner_squares: {} cannot have them, its border is not black",
                            family.name));
  }
  int border_bits = family.width_at_border;
  for (const TagFamily::Cell& bit : family.bits) border_bits = std::min(border_bits, bit.x);
  if (board.border_bits < 1 || border_bits < 1)
    throw Error(
        fmt::format("board: border_bits: {} cannot have {}", family.name, board.border_bits));
  const int more = board.border_bits - border_bits;
  family.width_at_border += 2 * more;
  family.total_width += 2 * more;
  for (TagFamily::Cell& bit : family.bits) {
    bit.x += more;
    bit.y += more;
  }
  return family;
}

// Which cells of a tag are black, row by row from above (as apriltag_to_image in AprilTag 3 has it:
// a white ring outside of a black border, or the outermost ring inside of a reversed one).
struct Pattern {
  int width = 0;
  std::vector<char> black;

  char& at(int x, int y) { return black[static_cast<std::size_t>(y * width + x)]; }
  bool all_black(int x0, int x1, int y) {
    for (int x = x0; x < x1; ++x)
      if (!at(x, y)) return false;
    return true;
  }
};

Pattern pattern(const TagFamily& family, int id) {
  if (id < 0 || static_cast<std::size_t>(id) >= family.codes.size())
    throw Error(fmt::format("board: tag id: must be in 0..{} of {}, got {}",
                            family.codes.size() - 1, family.name, id));
  const int n = family.total_width;
  Pattern result{n, std::vector<char>(static_cast<std::size_t>(n * n), 1)};
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

void add_tag(const Tag& tag, const TagFamily& family, std::vector<Rectangle>& cells) {
  Pattern cell = pattern(family, tag.id);
  const double side = tag.size / family.width_at_border;
  const auto place = [&](int x, int y) {
    return Vector2d((x - 0.5 * cell.width) * side, (0.5 * cell.width - y) * side);
  };
  for (int y = 0; y < cell.width; ++y) {
    for (int x = 0; x < cell.width; ++x) {
      if (!cell.at(x, y)) continue;
      // As wide as it goes, then as far down as that whole width is black.
      int right = x;
      while (right < cell.width && cell.at(right, y)) ++right;
      int below = y;
      while (below < cell.width && cell.all_black(x, right, below)) {
        for (int i = x; i < right; ++i) cell.at(i, below) = 0;
        ++below;
      }
      AlignedBox2d box;
      box.extend(place(x, y)).extend(place(right, below));
      cells.push_back(rectangle(tag.board_from_tag, box));
    }
  }
}

}  // namespace

std::vector<BoardPanel> board_panels(const Board& board, double margin_m) {
  std::vector<BoardPanel> panels;
  if (board.tags.empty()) return panels;
  if (one_plane(board.tags)) {
    panels.push_back(make_panel(board, board.tags, corner_squares(board), margin_m));
    return panels;
  }
  for (const Tag& tag : board.tags) panels.push_back(make_panel(board, {tag}, {}, margin_m));
  return panels;
}

std::vector<Rectangle> ink_cells(const Board& board, const BoardPanel& panel,
                                 const TagFamily& family) {
  const TagFamily bordered = with_border(family, board);
  std::vector<Rectangle> cells = panel.corner_squares;
  for (const Tag& tag : panel.tags) add_tag(tag, bordered, cells);
  return cells;
}

std::vector<Rectangle> ink_cells(const Board& board, const TagFamily& family) {
  std::vector<Rectangle> cells;
  for (const BoardPanel& panel : board_panels(board, 0)) {
    const std::vector<Rectangle> more = ink_cells(board, panel, family);
    cells.insert(cells.end(), more.begin(), more.end());
  }
  return cells;
}

}  // namespace tagcal
