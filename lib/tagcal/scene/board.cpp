#include "tagcal/scene/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/overloaded.hpp"

namespace tagcal {
using namespace internal;
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

std::int64_t product(int columns, int rows) { return std::int64_t{columns} * rows; }

void check(const Points&) {}  // taken as they are
void check(const Tags&) {}

void check(const AprilGrid& grid) {
  require_positive(grid.columns, "columns");
  require_positive(grid.rows, "rows");
  require_positive(grid.tag_size, "tag_size");
  require_positive(grid.border_bits, "border_bits");
  if (!(grid.tag_spacing >= 0) || !std::isfinite(grid.tag_spacing))
    throw Error(fmt::format("board: tag_spacing: must be >= 0, got {}", grid.tag_spacing));
  check_counts(product(grid.columns, grid.rows), grid.first_id, "first_id");
}

void check(const Checkerboard& board) {
  if (board.columns < 2 || board.rows < 2) {
    throw Error(fmt::format("board: must have 2 x 2 corners or more, got {} x {}", board.columns,
                            board.rows));
  }
  require_positive(board.column_spacing, "column_spacing");
  require_positive(board.row_spacing, "row_spacing");
  check_counts(product(board.columns, board.rows), board.first_id, "first_id");
}

Checkerboard squares_of(const Charuco& board) {
  const bool starts_black = board.legacy || board.square_rows % 2 == 1;
  return {board.square_columns - 1, board.square_rows - 1, board.square_size,
          board.square_size,        starts_black,          board.first_id};
}

void check(const Charuco& board) {
  check(squares_of(board));
  require_positive(board.marker_size, "marker size");
  if (board.marker_size >= board.square_size) {
    throw Error(fmt::format("board: markers must be smaller than a square of {} m, got {}",
                            board.square_size, board.marker_size));
  }
  const std::int64_t num_squares = product(board.square_columns, board.square_rows);
  check_counts((num_squares + 1) / 2, board.first_marker_id, "first_marker_id");
}

void check(const CircleGrid& grid) {
  if (grid.columns < 2 || grid.rows < 2) {
    throw Error(fmt::format("board: must have 2 x 2 circles or more, got {} x {}", grid.columns,
                            grid.rows));
  }
  require_positive(grid.spacing, "spacing");
  require_positive(grid.diameter, "diameter");
  if (grid.diameter >= centre_distance(grid)) {
    throw Error(
        fmt::format("board: diameter: must be less than {}, the distance of centres, got "
                    "{}",
                    centre_distance(grid), grid.diameter));
  }
  check_counts(product(grid.columns, grid.rows), grid.first_id, "first_id");
}

std::vector<Tag> tags_of(const AprilGrid& grid) {
  std::vector<Tag> tags;
  const double pitch = grid.tag_size * (1 + grid.tag_spacing);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Eigen::Vector3d centre(column * pitch + grid.tag_size / 2,
                                   row * pitch + grid.tag_size / 2, 0);
      tags.push_back({grid.first_id + row * grid.columns + column, grid.tag_size,
                      Pose(Eigen::Quaterniond::Identity(), centre)});
    }
  }
  return tags;
}

std::vector<Tag> tags_of(const Charuco& board) {
  std::vector<Tag> markers;
  const Checkerboard squares = squares_of(board);
  int id = board.first_marker_id;
  for (int row = board.square_rows - 1; row >= 0; --row) {
    for (int column = 0; column < board.square_columns; ++column) {
      const bool is_black = ((row + column) % 2 == 0) == squares.starts_black;
      if (is_black) continue;
      const Eigen::Vector3d centre((column - 0.5) * squares.column_spacing,
                                   (row - 0.5) * squares.row_spacing, 0);
      markers.push_back({id++, board.marker_size, Pose(Eigen::Quaterniond::Identity(), centre)});
    }
  }
  return markers;
}

std::vector<TargetPoint> points_of(const std::vector<Tag>& tags) {
  std::vector<TargetPoint> points;
  points.reserve(4 * tags.size());
  for (const Tag& tag : tags) {
    const auto corners = tag_corners(tag);
    for (int i = 0; i < 4; ++i)
      points.push_back({{tag.id, i}, corners[static_cast<std::size_t>(i)]});
  }
  return points;
}

std::vector<TargetPoint> points_of(const CircleGrid& grid) {
  std::vector<TargetPoint> points;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const int x = grid.asymmetric ? 2 * column + (grid.rows - 1 - row) % 2 : column;
      points.push_back({{grid.first_id + row * grid.columns + column, 0},
                        {x * grid.spacing, row * grid.spacing, 0}});
    }
  }
  return points;
}

std::vector<TargetPoint> points_of(const Checkerboard& board) {
  std::vector<TargetPoint> points;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      points.push_back({{board.first_id + row * board.columns + column, 0},
                        {column * board.column_spacing, row * board.row_spacing, 0}});
  return points;
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

Board make_board(BoardPattern pattern, const Substrate& substrate) {
  std::visit([](const auto& kind) { check(kind); }, pattern);
  check_substrate(substrate);
  return {std::move(pattern), substrate};
}

std::array<Eigen::Vector3d, 4> tag_corners(const Tag& tag) {
  const double half = tag.size / 2;
  return {tag.board_from_tag * Eigen::Vector3d(-half, -half, 0),
          tag.board_from_tag * Eigen::Vector3d(half, -half, 0),
          tag.board_from_tag * Eigen::Vector3d(half, half, 0),
          tag.board_from_tag * Eigen::Vector3d(-half, half, 0)};
}

PointKind point_kind(const Board& board) {
  if (std::holds_alternative<CircleGrid>(board.pattern)) return PointKind::circle_centre;
  if (checkers(board)) return PointKind::checker_corner;
  return tag_kind(board) ? PointKind::tag_corner : PointKind::measured;
}

std::vector<TargetPoint> target_points(const Board& board) {
  std::vector<TargetPoint> points =
      std::visit(Overloaded{[](const Points& measured) { return measured.points; },
                            [](const Tags& single) { return points_of(single.tags); },
                            [](const AprilGrid& grid) { return points_of(tags_of(grid)); },
                            [](const Checkerboard& squares) { return points_of(squares); },
                            [](const CircleGrid& circles) { return points_of(circles); },
                            [](const Charuco& charuco) { return points_of(squares_of(charuco)); }},
                 board.pattern);
  std::ranges::sort(points, {}, &TargetPoint::id);
  return points;
}

std::vector<Tag> tags_of(const Board& board) {
  return std::visit(Overloaded{[](const Tags& single) { return single.tags; },
                               [](const AprilGrid& grid) { return tags_of(grid); },
                               [](const Charuco& charuco) { return tags_of(charuco); },
                               [](const auto&) { return std::vector<Tag>{}; }},
                    board.pattern);
}

std::optional<TagKind> tag_kind(const Board& board) {
  return std::visit(
      [](const auto& kind) -> std::optional<TagKind> {
        if constexpr (requires { kind.border_bits; }) return TagKind{kind.family, kind.border_bits};
        if constexpr (requires { kind.dictionary; }) return TagKind{kind.dictionary, 1};
        return std::nullopt;
      },
      board.pattern);
}

std::optional<Checkerboard> checkers(const Board& board) {
  using Result = std::optional<Checkerboard>;
  return std::visit(Overloaded{[](const Checkerboard& squares) -> Result { return squares; },
                               [](const Charuco& charuco) -> Result { return squares_of(charuco); },
                               [](const auto&) -> Result { return std::nullopt; }},
                    board.pattern);
}

std::optional<PointGrid> point_grid(const Board& board) {
  if (const auto* const circles = std::get_if<CircleGrid>(&board.pattern))
    return PointGrid{circles->columns, circles->rows, circles->first_id};
  const auto squares = checkers(board);
  if (!squares) return std::nullopt;
  return PointGrid{squares->columns, squares->rows, squares->first_id};
}

double centre_distance(const CircleGrid& grid) {
  return grid.asymmetric ? std::numbers::sqrt2 * grid.spacing : grid.spacing;
}

}  // namespace tagcal
