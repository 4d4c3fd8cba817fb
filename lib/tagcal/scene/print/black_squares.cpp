#include "tagcal/scene/print/black_squares.hpp"

#include "tagcal/internal/overloaded.hpp"

namespace tagcal::internal {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Which of a grown square's corners are left out, because another rectangle covers them.
struct LeftOut {
  bool lower_left = false;
  bool lower_right = false;
  bool upper_left = false;
  bool upper_right = false;
};

// Adds a square whose edges moved outwards by `spread_m`, without the corners that are left out.
void add_square(AlignedBox2d square, double spread_m, const LeftOut& left_out,
                std::vector<Rectangle>& cells) {
  square.min().array() -= spread_m;
  square.max().array() += spread_m;
  const Vector2d &low = square.min(), &high = square.max();
  const auto add = [&](double left, double bottom, double right, double top) {
    cells.push_back(rectangle(Pose(), AlignedBox2d(Vector2d(left, bottom), Vector2d(right, top))));
  };
  const bool below = left_out.lower_left || left_out.lower_right;
  const bool above = left_out.upper_left || left_out.upper_right;
  const double shared = 2 * spread_m;
  const auto strip = [&](double bottom, bool no_left, bool no_right) {
    add(low.x() + (no_left ? shared : 0), bottom, high.x() - (no_right ? shared : 0),
        bottom + shared);
  };
  if (below) strip(low.y(), left_out.lower_left, left_out.lower_right);
  add(low.x(), low.y() + (below ? shared : 0), high.x(), high.y() - (above ? shared : 0));
  if (above) strip(high.y() - shared, left_out.upper_left, left_out.upper_right);
}

// Kalibr's squares touch the corners of up to four tags.
std::vector<Rectangle> corner_squares(const AprilGrid& grid, double spread_m) {
  std::vector<Rectangle> cells;
  if (!grid.corner_squares || grid.tag_spacing == 0) return cells;
  const double gap = grid.tag_spacing * grid.tag_size, pitch = grid.tag_size + gap;
  for (int row = 0; row <= grid.rows; ++row) {
    for (int column = 0; column <= grid.columns; ++column) {
      const Vector2d high(column * pitch, row * pitch);
      const bool grown = spread_m > 0, left = grown && column > 0,
                 right = grown && column < grid.columns;
      const LeftOut tags = {.lower_left = left && row > 0,
                            .lower_right = right && row > 0,
                            .upper_left = left && row < grid.rows,
                            .upper_right = right && row < grid.rows};
      add_square({high - Vector2d::Constant(gap), high}, spread_m, tags, cells);
    }
  }
  return cells;
}

// A square meets other black ones at its corners; the lower of two has what they have in common.
std::vector<Rectangle> checker_squares(const Checkerboard& board, double spread_m) {
  std::vector<Rectangle> cells;
  const Vector2d size(board.column_spacing, board.row_spacing);
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      const bool is_black = ((row + column) % 2 == 0) == board.starts_black;
      if (!is_black) continue;
      const Vector2d low = size.cwiseProduct(Vector2d(column - 1, row - 1));
      const bool grown = spread_m > 0 && row > 0;
      add_square(
          {low, low + size}, spread_m,
          {.lower_left = grown && column > 0, .lower_right = grown && column < board.columns},
          cells);
    }
  }
  return cells;
}

}  // namespace

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

std::vector<Rectangle> black_squares(const Board& board, double spread_m) {
  if (const auto squares = checkers(board)) return checker_squares(*squares, spread_m);
  return std::visit(
      Overloaded{[&](const AprilGrid& grid) { return corner_squares(grid, spread_m); },
                 [](const auto&) { return std::vector<Rectangle>{}; }},
      board.pattern);
}

AlignedBox2d checkerboard_area(const Checkerboard& board) {
  const Vector2d size(board.column_spacing, board.row_spacing);
  return {-size, size.cwiseProduct(Vector2d(board.columns, board.rows))};
}

}  // namespace tagcal::internal
