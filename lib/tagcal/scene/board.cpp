#include "tagcal/scene/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

void require_positive(double value, const char* key) {
  if (!(value > 0) || !std::isfinite(value))
    throw Error(fmt::format("board: {}: must be > 0, got {}", key, value));
}

void check(const Grid& grid, int border_bits) {
  require_positive(grid.columns, "columns");
  require_positive(grid.rows, "rows");
  require_positive(grid.tag_size, "tag_size");
  require_positive(border_bits, "border_bits");
  if (!(grid.tag_spacing >= 0) || !std::isfinite(grid.tag_spacing))
    throw Error(fmt::format("board: tag_spacing: must be >= 0, got {}", grid.tag_spacing));
  if (grid.first_id < 0)
    throw Error(fmt::format("board: first_id: must be >= 0, got {}", grid.first_id));
}

}  // namespace

Board grid_board(const Grid& grid, std::string family, int border_bits, bool corner_squares) {
  check(grid, border_bits);
  Board board;
  board.family = std::move(family);
  board.border_bits = border_bits;
  board.corner_squares = corner_squares;
  board.grid = grid;
  const double pitch = grid.tag_size * (1 + grid.tag_spacing);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Eigen::Vector3d centre(column * pitch + grid.tag_size / 2,
                                   row * pitch + grid.tag_size / 2, 0);
      board.tags.push_back({grid.first_id + row * grid.columns + column, grid.tag_size,
                            Pose(Eigen::Quaterniond::Identity(), centre)});
    }
  }
  return board;
}

std::array<Eigen::Vector3d, 4> tag_corners(const Tag& tag) {
  const double half = tag.size / 2;
  return {tag.board_from_tag * Eigen::Vector3d(-half, -half, 0),
          tag.board_from_tag * Eigen::Vector3d(half, -half, 0),
          tag.board_from_tag * Eigen::Vector3d(half, half, 0),
          tag.board_from_tag * Eigen::Vector3d(-half, half, 0)};
}

std::vector<TargetPoint> target_points(const Board& board) {
  std::vector<TargetPoint> points = board.points;
  points.reserve(points.size() + 4 * board.tags.size());
  for (const Tag& tag : board.tags) {
    const auto corners = tag_corners(tag);
    for (int i = 0; i < 4; ++i)
      points.push_back({{tag.id, i}, corners[static_cast<std::size_t>(i)]});
  }
  std::ranges::sort(points, {}, &TargetPoint::id);
  return points;
}

}  // namespace tagcal
