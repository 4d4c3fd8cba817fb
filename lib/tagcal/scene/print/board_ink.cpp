#include "tagcal/scene/surfaces.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/overloaded.hpp"
#include "tagcal/scene/print/printed_tag.hpp"

namespace tagcal {
using namespace internal;
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

Vector3d normal(const Tag& tag) { return tag.board_from_tag.rotation() * Vector3d::UnitZ(); }

bool one_plane(const std::vector<Tag>& tags) {
  const Vector3d n = normal(tags.front());
  const Vector3d& origin = tags.front().board_from_tag.translation();
  return std::ranges::all_of(tags, [&](const Tag& tag) {
    const double height = n.dot(tag.board_from_tag.translation() - origin);
    return (normal(tag) - n).norm() < 1e-9 && std::abs(height) < 1e-9;
  });
}

Pose board_from_sheet(const std::vector<Tag>& tags) {
  const bool upright = (normal(tags.front()) - Vector3d::UnitZ()).norm() < 1e-9 && tags.size() > 1;
  const Pose& tag_pose = tags.front().board_from_tag;
  return Pose(upright ? Eigen::Quaterniond::Identity() : tag_pose.rotation(),
              tag_pose.translation());
}

BoardPanel tags_panel(const std::string& family, std::vector<Tag> tags,
                      std::vector<Rectangle> squares, double margin_m) {
  const Pose from_sheet = board_from_sheet(tags);
  const Pose sheet_from_board = from_sheet.inverse();
  AlignedBox2d box;
  BoardPanel panel;
  for (Tag tag : tags) {
    const auto corners = tag_corners(tag);
    for (int i = 0; i < 4; ++i)
      panel.points.push_back({{tag.id, i}, corners[static_cast<std::size_t>(i)]});
    tag.size *= 1 + 2 * outer_share(family);
    for (const Vector3d& corner : tag_corners(tag))
      box.extend((sheet_from_board * corner).head<2>());
  }
  for (const Rectangle& square : squares)
    for (const Vector3d& corner : square) box.extend((sheet_from_board * corner).head<2>());
  box.min().array() -= margin_m;
  box.max().array() += margin_m;
  panel.paper = rectangle(from_sheet, box);
  panel.tags = std::move(tags);
  panel.squares = std::move(squares);
  return panel;
}

BoardPanel checkerboard_panel(const Board& board, const Checkerboard& squares, double margin_m) {
  AlignedBox2d box = checkerboard_area(squares);
  box.min().array() -= margin_m;
  box.max().array() += margin_m;
  return {rectangle(Pose(), box), tags_of(board), black_squares(board), target_points(board)};
}

constexpr int kDiscSides = 256;      // numeric: the border within 6e-5 radii
constexpr int kDrawnDiscSides = 24;  // numeric: round to the eye

std::vector<InkCell> discs(const CircleGrid& grid, double spread_m, int sides) {
  const double step = 2 * std::numbers::pi / sides;
  const double circle = grid.diameter / 2 + spread_m;
  const double radius = circle * std::sqrt(step / std::sin(step));  // of the corners: equal areas
  std::vector<InkCell> cells;
  for (const TargetPoint& centre : target_points({grid, {}})) {
    InkCell& disc = cells.emplace_back();
    for (int i = 0; i < sides; ++i)
      disc.emplace_back(centre.position +
                        radius * Vector3d(std::cos(i * step), std::sin(i * step), 0));
  }
  return cells;
}

InkCell cell_of(const Rectangle& corners) { return {corners.begin(), corners.end()}; }

BoardPanel circles_panel(const Board& board, const CircleGrid& grid, double margin_m) {
  BoardPanel panel;
  panel.points = target_points(board);
  AlignedBox2d box;
  for (const TargetPoint& point : panel.points) box.extend(point.position.head<2>());
  box.min().array() -= grid.diameter / 2 + margin_m;
  box.max().array() += grid.diameter / 2 + margin_m;
  panel.paper = rectangle(Pose(), box);
  return panel;
}

// A line between cells, which spread_out() moved by less than half a cell, after rounding to the
// pixels of a drawing; all in cells. The corners of the tag are not rounded.
double drawn_line(double line, const TagFamily& family, double pixel) {
  if (pixel == 0) return line;
  const double first = 0.5 * (family.total_width - family.width_at_border),
               last = first + family.width_at_border;
  const double edge = std::round(line), corner = edge < last ? first : last;
  return corner + pixel * std::round((edge - corner) / pixel) + (line - edge);
}

void add_tag(const Tag& tag, const TagFamily& family, double spread_m, double grid_m,
             std::vector<InkCell>& cells) {
  const double side = tag.size / family.width_at_border;
  PrintedTag cell = spread_out(printed_tag(family, tag.id), spread_m / side);
  for (double& line : cell.lines) line = drawn_line(line, family, grid_m / side);
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
      cells.push_back(cell_of(rectangle(tag.board_from_tag, box)));
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

// Returns true if an edge of the print that moves by `spread_m` (>= 0), and in tags by half of
// `grid_m`, could meet another one.
bool edges_meet(const Board& board, const BoardPanel& panel, const TagFamily& family,
                double spread_m, double grid_m) {
  if (!std::isfinite(spread_m)) return true;
  for (const Tag& tag : panel.tags)
    if (2 * spread_m >= tag.size / family.width_at_border - grid_m) return true;
  const double outer = outer_share(family.name);
  return std::visit(
      Overloaded{
          [](const Points&) { return false; },
          [&](const Tags&) { return overlapping_tags(panel.tags, outer, spread_m).has_value(); },
          [&](const AprilGrid& grid) {
            return 2 * spread_m >= (grid.tag_spacing - 2 * outer) * grid.tag_size;
          },
          [&](const Checkerboard& squares) {
            return 2 * spread_m >= std::min(squares.column_spacing, squares.row_spacing);
          },
          [&](const Charuco& charuco) {
            return 2 * spread_m >= (charuco.square_size - charuco.marker_size) / 2;
          },
          [&](const CircleGrid& grid) {
            return 2 * spread_m >= std::min(grid.diameter, centre_distance(grid) - grid.diameter);
          }},
      board.pattern);
}

void check_grid(const BoardPanel& panel, const TagFamily& family, double grid_m) {
  const bool fits = std::ranges::all_of(
      panel.tags, [&](const Tag& tag) { return grid_m < tag.size / family.width_at_border; });
  if (!(grid_m >= 0) || !fits)
    throw Error(
        fmt::format("board: print_grid_m: must be >= 0 and less than a cell of the tags, "
                    "got {}",
                    grid_m));
}

void check_spread(const Board& board, const BoardPanel& panel, const TagFamily& family,
                  double spread_m, double grid_m) {
  if (spread_m == 0 || !edges_meet(board, panel, family, std::abs(spread_m), grid_m)) return;
  throw Error(
      fmt::format("board: ink_spread_m: must be less than half a {} and half "
                  "of what is between them, got {}",
                  point_kind(board) == PointKind::circle_centre ? "circle's diameter"
                  : !checkers(board)                            ? "cell of the tags"
                  : panel.tags.empty()                          ? "square"
                                       : "cell of the markers, half a square",
                  spread_m));
}

}  // namespace

// A sweep along the longer side of the board: boards may have 100,000 tags.
std::optional<std::pair<int, int>> overlapping_tags(const std::vector<Tag>& tags, double outer,
                                                    double spread_m) {
  std::vector<Vector2d> centres;
  AlignedBox2d box;
  double most = 0;
  const auto half = [&](std::size_t i) { return tags[i].size * (0.5 + outer) + spread_m; };
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const Pose in_first = tags[0].board_from_tag.inverse() * tags[i].board_from_tag;
    centres.emplace_back(in_first.translation().head<2>());
    box.extend(centres.back());
    most = std::max(most, half(i));
  }
  const int axis = !tags.empty() && box.sizes().y() > box.sizes().x() ? 1 : 0;
  std::vector<std::size_t> order(tags.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return centres[i][axis]; });
  for (std::size_t n = 0; n < order.size(); ++n) {
    const std::size_t i = order[n];
    for (std::size_t k = n; k-- > 0;) {
      const std::size_t j = order[k];
      const double reach = std::numbers::sqrt2 * (half(i) + most);
      if (centres[i][axis] - centres[j][axis] > reach) break;
      if (std::abs(centres[i][1 - axis] - centres[j][1 - axis]) > reach) continue;
      if (!has_beyond(tags[i], half(i), tags[j], half(j)) &&
          !has_beyond(tags[j], half(j), tags[i], half(i)))
        return std::minmax(tags[i].id, tags[j].id);
    }
  }
  return std::nullopt;
}

std::optional<std::pair<int, int>> overlapping_tags(const Board& board) {
  constexpr double kTouching_m = 1e-6;
  const auto kind = tag_kind(board);
  if (!kind) return std::nullopt;
  return overlapping_tags(tags_of(board), outer_share(kind->family), -kTouching_m);
}

std::vector<BoardPanel> board_panels(const Board& board, double margin_m) {
  if (const auto squares = checkers(board)) return {checkerboard_panel(board, *squares, margin_m)};
  if (const auto* const circles = std::get_if<CircleGrid>(&board.pattern))
    return {circles_panel(board, *circles, margin_m)};
  const std::vector<Tag> tags = tags_of(board);
  if (tags.empty()) return {};
  const std::string family = tag_kind(board)->family;
  if (one_plane(tags)) return {tags_panel(family, tags, black_squares(board), margin_m)};
  std::vector<BoardPanel> panels;
  for (const Tag& tag : tags) panels.push_back(tags_panel(family, {tag}, {}, margin_m));
  return panels;
}

std::vector<InkCell> ink_cells(const Board& board, const BoardPanel& panel, const TagFamily& family,
                               double spread_m, double grid_m) {
  const TagFamily bordered = panel.tags.empty() ? TagFamily{} : with_border(family, board);
  check_grid(panel, bordered, grid_m);
  check_spread(board, panel, bordered, spread_m, grid_m);
  if (const auto* const circles = std::get_if<CircleGrid>(&board.pattern))
    return discs(*circles, spread_m, kDiscSides);
  std::vector<InkCell> cells;
  if (!panel.squares.empty())
    for (const Rectangle& square : black_squares(board, spread_m)) cells.push_back(cell_of(square));
  for (const Tag& tag : panel.tags) add_tag(tag, bordered, spread_m, grid_m, cells);
  return cells;
}

std::vector<InkCell> ink_cells(const Board& board, const TagFamily& family) {
  std::vector<InkCell> cells;
  for (const BoardPanel& panel : board_panels(board, 0)) {
    const std::vector<InkCell> more = ink_cells(board, panel, family);
    cells.insert(cells.end(), more.begin(), more.end());
  }
  return cells;
}

std::vector<InkCell> drawn_print(const Board& board, const BoardPanel& panel) {
  if (const auto* const circles = std::get_if<CircleGrid>(&board.pattern))
    return discs(*circles, 0, kDrawnDiscSides);
  std::vector<InkCell> cells;
  if (checkers(board))
    for (const Rectangle& square : panel.squares) cells.push_back(cell_of(square));
  for (const Tag& tag : panel.tags) cells.push_back(cell_of(tag_corners(tag)));
  return cells;
}

}  // namespace tagcal
