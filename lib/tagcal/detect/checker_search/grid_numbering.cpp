#include "tagcal/detect/checker_search/grid_numbering.hpp"

#include <algorithm>
#include <vector>

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// The bounds of a grid's cells.
struct Bounds {
  GridCell low{0, 0}, high{0, 0};
  int columns() const { return high.first - low.first + 1; }
  int rows() const { return high.second - low.second + 1; }
};

Bounds bounds_of(const JunctionGrid& grid) {
  Bounds bounds{grid.begin()->first, grid.begin()->first};
  for (const auto& [cell, at] : grid) {
    bounds.low = {std::min(bounds.low.first, cell.first), std::min(bounds.low.second, cell.second)};
    bounds.high = {std::max(bounds.high.first, cell.first),
                   std::max(bounds.high.second, cell.second)};
  }
  return bounds;
}

// The numberings of a grid with the board's number of columns and rows.
std::vector<GridNumbering> numberings(const Bounds& bounds, const CheckerPrint& print) {
  std::vector<GridNumbering> result;
  // The board's y is a quarter turn from its x towards the picture's top.
  constexpr std::pair<GridCell, GridCell> kAxes[] = {
      {{1, 0}, {0, -1}}, {{0, -1}, {-1, 0}}, {{-1, 0}, {0, 1}}, {{0, 1}, {1, 0}}};
  for (const auto& [x, y] : kAxes) {
    const bool is_turned = x.first == 0;
    if ((is_turned ? bounds.rows() : bounds.columns()) != print.columns() ||
        (is_turned ? bounds.columns() : bounds.rows()) != print.rows())
      continue;
    result.push_back({x,
                      y,
                      {x.first + y.first > 0 ? bounds.low.first : bounds.high.first,
                       x.second + y.second > 0 ? bounds.low.second : bounds.high.second}});
  }
  return result;
}

// Mean direction of the board's y in the picture.
Vector2d up_in_picture(const JunctionGrid& grid, const GridCell& y) {
  Vector2d sum = Vector2d::Zero();
  for (const auto& [cell, at] : grid)
    if (const auto next = grid.find({cell.first + y.first, cell.second + y.second});
        next != grid.end())
      sum += next->second - at;
  return sum.normalized();
}

}  // namespace

CheckerCell size_of(const JunctionGrid& grid) {
  const Bounds bounds = bounds_of(grid);
  return {bounds.columns(), bounds.rows()};
}

std::optional<GridNumbering> numbering_of(const JunctionGrid& grid, const CheckerPrint& print) {
  const std::vector<GridNumbering> possible = numberings(bounds_of(grid), print);
  const auto best = std::ranges::max_element(possible, {}, [&](const GridNumbering& numbering) {
    return std::pair(numbering.starts_black() == print.starts_black(),
                     -up_in_picture(grid, numbering.y).y());
  });
  return best == possible.end() ? std::nullopt : std::optional(*best);
}

bool is_of_size(const JunctionGrid& grid, const CheckerPrint& print) {
  return !numberings(bounds_of(grid), print).empty();
}

}  // namespace tagcal::internal
