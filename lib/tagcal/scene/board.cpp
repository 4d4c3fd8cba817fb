#include "tagcal/scene/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

constexpr std::array<std::string_view, 3> kMaterialNames = {"paper", "aluminium", "glass"};

void check(const Tolerance& tolerance, const char* key) {
  const double* const share = std::get_if<double>(&tolerance);
  if (share && !(*share > 0 && *share <= kMaxTolerance))
    throw Error(
        fmt::format("board: {}: must be > 0 and at most {}, got {}", key, kMaxTolerance, *share));
}

void require_positive(double value, const char* key) {
  if (!(value > 0) || !std::isfinite(value))
    throw Error(fmt::format("board: {}: must be > 0, got {}", key, value));
}

// `num_parts`: tags or corners, which have the ids from first_id on.
void check_counts(std::int64_t num_parts, std::int64_t first_id, const char* key) {
  if (num_parts > kMaxBoardParts)
    throw Error(fmt::format("board: columns * rows: must be at most {}, got {}", kMaxBoardParts,
                            num_parts));
  if (first_id < 0) throw Error(fmt::format("board: {}: must be >= 0, got {}", key, first_id));
  const std::int64_t last_id = first_id + num_parts - 1;
  if (last_id > std::numeric_limits<int>::max())
    throw Error(
        fmt::format("board: {}: the ids must stay below 2^31, but end at {}", key, last_id));
}

void check(const Grid& grid, int border_bits) {
  require_positive(grid.columns, "columns");
  require_positive(grid.rows, "rows");
  require_positive(grid.tag_size, "tag_size");
  require_positive(border_bits, "border_bits");
  if (!(grid.tag_spacing >= 0) || !std::isfinite(grid.tag_spacing))
    throw Error(fmt::format("board: tag_spacing: must be >= 0, got {}", grid.tag_spacing));
  check_counts(std::int64_t{grid.columns} * grid.rows, grid.first_id, "first_id");
}

void check(const Checkerboard& board) {
  if (board.columns < 2 || board.rows < 2) {
    throw Error(fmt::format("board: must have 2 x 2 corners or more, got {} x {}", board.columns,
                            board.rows));
  }
  require_positive(board.column_spacing, "column_spacing");
  require_positive(board.row_spacing, "row_spacing");
  check_counts(std::int64_t{board.columns} * board.rows, board.first_id, "first_id");
}

void check(const CharucoMarkers& markers, const Checkerboard& board) {
  check(board);
  require_positive(markers.size, "marker size");
  if (board.column_spacing != board.row_spacing) {
    throw Error(fmt::format("board: squares of a ChArUco board must be square, got {} x {} m",
                            board.column_spacing, board.row_spacing));
  }
  if (markers.size >= board.column_spacing) {
    throw Error(fmt::format("board: markers must be smaller than a square of {} m, got {}",
                            board.column_spacing, markers.size));
  }
  const std::int64_t num_squares = (std::int64_t{board.columns} + 1) * (board.rows + 1);
  check_counts((num_squares + 1) / 2, markers.first_marker_id, "first_marker_id");
}

}  // namespace

std::string_view material_name(Material material) {
  return kMaterialNames[static_cast<std::size_t>(material)];
}

std::optional<Material> material_named(std::string_view name) {
  const auto found = std::ranges::find(kMaterialNames, name);
  if (found == kMaterialNames.end()) return std::nullopt;
  return static_cast<Material>(found - kMaterialNames.begin());
}

void check_substrate(const Substrate& substrate) {
  check(substrate.flatness, "flatness");
  check(substrate.print, "print");
}

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

Board checkerboard_board(const Checkerboard& checkerboard) {
  check(checkerboard);
  Board board;
  board.border_bits = 1;
  board.corner_squares = false;
  board.checkerboard = checkerboard;
  for (int row = 0; row < checkerboard.rows; ++row) {
    for (int column = 0; column < checkerboard.columns; ++column) {
      const int id = checkerboard.first_id + row * checkerboard.columns + column;
      board.points.push_back(
          {{id, 0}, {column * checkerboard.column_spacing, row * checkerboard.row_spacing, 0}});
    }
  }
  return board;
}

Board charuco_board(const Checkerboard& checkerboard, const CharucoMarkers& markers) {
  check(markers, checkerboard);
  Checkerboard squares = checkerboard;
  const int square_rows = squares.rows + 1, square_columns = squares.columns + 1;
  squares.starts_black = markers.legacy || square_rows % 2 == 1;
  Board board = checkerboard_board(squares);
  board.charuco = markers;
  board.family = markers.dictionary;
  int id = markers.first_marker_id;
  for (int row = square_rows - 1; row >= 0; --row) {
    for (int column = 0; column < square_columns; ++column) {
      const bool is_black = ((row + column) % 2 == 0) == squares.starts_black;
      if (is_black) continue;
      const Eigen::Vector3d centre((column - 0.5) * squares.column_spacing,
                                   (row - 0.5) * squares.row_spacing, 0);
      board.tags.push_back({id++, markers.size, Pose(Eigen::Quaterniond::Identity(), centre)});
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
  if (board.charuco) return points;
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
