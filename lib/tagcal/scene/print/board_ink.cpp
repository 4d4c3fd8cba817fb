#include "tagcal/scene/print/board_ink.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/scene/print/printed_tag.hpp"

namespace tagcal::internal {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Cells outside of the corners that the detector reports, and cells between the corners. Other
// families have only a white frame there. (The visibility of corners must not need the patterns.)
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

// Adds one of Kalibr's squares, which touches the corners of up to four tags. A grown square leaves
// out the area that it would share with the tags.
void add_square(const Grid& grid, int column, int row, double spread_m,
                std::vector<Rectangle>& cells) {
  const double gap = grid.tag_spacing * grid.tag_size, pitch = grid.tag_size + gap;
  const Vector2d high(column * pitch + spread_m, row * pitch + spread_m);
  const Vector2d low = high - Vector2d::Constant(gap + 2 * spread_m);
  const auto add = [&](double left, double bottom, double right, double top) {
    cells.push_back(rectangle(Pose(), AlignedBox2d(Vector2d(left, bottom), Vector2d(right, top))));
  };
  if (spread_m <= 0) return add(low.x(), low.y(), high.x(), high.y());
  const double shared = 2 * spread_m;
  const auto strip = [&](int tag_row, double bottom) {
    const bool is_row = tag_row >= 0 && tag_row < grid.rows;
    add(low.x() + (is_row && column > 0 ? shared : 0), bottom,
        high.x() - (is_row && column < grid.columns ? shared : 0), bottom + shared);
  };
  strip(row - 1, low.y());
  add(low.x(), low.y() + shared, high.x(), high.y() - shared);
  strip(row, high.y() - shared);
}

std::vector<Rectangle> corner_squares(const Board& board, double spread_m) {
  std::vector<Rectangle> squares;
  if (!board.grid || !board.corner_squares || board.grid->tag_spacing == 0) return squares;
  for (int row = 0; row <= board.grid->rows; ++row)
    for (int column = 0; column <= board.grid->columns; ++column)
      add_square(*board.grid, column, row, spread_m, squares);
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

void add_tag(const Tag& tag, const TagFamily& family, double spread_m,
             std::vector<Rectangle>& cells) {
  const double side = tag.size / family.width_at_border;
  PrintedTag cell = spread_out(printed_tag(family, tag.id), spread_m / side);
  const double middle = 0.5 * family.total_width;
  const auto place = [&](int x, int y) {
    return Vector2d((cell.lines[static_cast<std::size_t>(x)] - middle) * side,
                    (middle - cell.lines[static_cast<std::size_t>(y)]) * side);
  };
  for (int y = 0; y < cell.width(); ++y) {
    for (int x = 0; x < cell.width(); ++x) {
      if (!cell.is_black(x, y)) continue;
      // Extends the rectangle to the right, then down as long as the whole width is black.
      int right = x;
      while (cell.is_black(right, y)) ++right;
      int below = y;
      while (cell.all_black(x, right, below)) {
        for (int i = x; i < right; ++i) cell.at(i, below) = 0;
        ++below;
      }
      AlignedBox2d box;
      box.extend(place(x, y)).extend(place(right, below));
      cells.push_back(rectangle(tag.board_from_tag, box));
    }
  }
}

// Returns true if a side of `a` separates it from `b`; both are squares in one plane.
bool has_beyond(const Tag& a, double half_a, const Tag& b, double half_b) {
  const Pose a_from_b = a.board_from_tag.inverse() * b.board_from_tag;
  const Eigen::Matrix3d r = a_from_b.rotation_matrix();
  const double reach = half_a + half_b * (std::abs(r(0, 0)) + std::abs(r(0, 1)));
  return a_from_b.translation().head<2>().cwiseAbs().maxCoeff() > reach;
}

bool tags_overlap(const std::vector<Tag>& tags, double outer, double spread_m) {
  for (std::size_t i = 0; i < tags.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double half_i = tags[i].size * (0.5 + outer) + spread_m;
      const double half_j = tags[j].size * (0.5 + outer) + spread_m;
      if (!has_beyond(tags[i], half_i, tags[j], half_j) &&
          !has_beyond(tags[j], half_j, tags[i], half_i))
        return true;
    }
  }
  return false;
}

void check_spread(const Board& board, const BoardPanel& panel, const TagFamily& family,
                  double spread_m) {
  if (spread_m == 0) return;
  const double outer = outer_share(board.family);
  bool meets = !std::isfinite(spread_m);
  for (const Tag& tag : panel.tags)
    meets = meets || 2 * std::abs(spread_m) >= tag.size / family.width_at_border;
  if (board.grid) {
    const double between = (board.grid->tag_spacing - 2 * outer) * board.grid->tag_size;
    meets = meets || 2 * std::abs(spread_m) >= between;
  } else {
    meets = meets || tags_overlap(panel.tags, outer, std::abs(spread_m));
  }
  if (!meets) return;
  throw Error(
      fmt::format("board: ink_spread_m: must be less than half a cell of the tags and half "
                  "of what is between them, got {}",
                  spread_m));
}

}  // namespace

std::vector<BoardPanel> board_panels(const Board& board, double margin_m) {
  std::vector<BoardPanel> panels;
  if (board.tags.empty()) return panels;
  if (one_plane(board.tags)) {
    panels.push_back(make_panel(board, board.tags, corner_squares(board, 0), margin_m));
    return panels;
  }
  for (const Tag& tag : board.tags) panels.push_back(make_panel(board, {tag}, {}, margin_m));
  return panels;
}

std::vector<Rectangle> ink_cells(const Board& board, const BoardPanel& panel,
                                 const TagFamily& family, double spread_m) {
  const TagFamily bordered = with_border(family, board);
  check_spread(board, panel, bordered, spread_m);
  std::vector<Rectangle> cells;
  if (!panel.corner_squares.empty()) cells = corner_squares(board, spread_m);
  for (const Tag& tag : panel.tags) add_tag(tag, bordered, spread_m, cells);
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

}  // namespace tagcal::internal
