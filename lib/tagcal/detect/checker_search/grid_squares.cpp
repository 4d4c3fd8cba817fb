#include "tagcal/detect/checker_search/grid_squares.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tagcal/detect/board_search/cell_levels.hpp"
#include "tagcal/detect/checker_search/grid_numbering.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

// Grey levels of a square, black ones negative.
struct SquareLevels {
  double middle = 0;
  double aside = 0;  // mean of the four places halfway between its middle and its corners
};

// By the cell of its first junction.
using Squares = std::map<GridCell, SquareLevels>;

// The square's corners from the first one on in rows; no value if one is missing.
std::optional<Eigen::Matrix3d> pixels_of_square(const JunctionGrid& grid, const GridCell& cell) {
  Eigen::Matrix<double, 2, 4> corners;
  for (int k = 0; k < 4; ++k) {
    const auto corner = grid.find({cell.first + k % 2, cell.second + k / 2});
    if (corner == grid.end()) return std::nullopt;
    corners.col(k) = corner->second;
  }
  Eigen::Matrix3d pixels = Eigen::Matrix3d::Identity();
  pixels.topRows<2>().col(0) =
      (corners.col(1) + corners.col(3) - corners.col(0) - corners.col(2)) / 2;
  pixels.topRows<2>().col(1) =
      (corners.col(2) + corners.col(3) - corners.col(0) - corners.col(1)) / 2;
  pixels.topRows<2>().col(2) = corners.rowwise().mean();
  return pixels;
}

Squares squares_of(const ImageView8& image, const JunctionGrid& grid) {
  constexpr double kHalfway = 1.0 / 4;  // of a side, along both, from the middle towards a corner
  Squares squares;
  for (const auto& [cell, at] : grid) {
    const auto pixels = pixels_of_square(grid, cell);
    if (!pixels) continue;
    const double sign = (cell.first + cell.second) % 2 == 0 ? 1 : -1;
    squares[cell] = {sign * cell_levels(image, *pixels, 1, 0).front(),
                     sign * cell_levels(image, *pixels, 1, kHalfway).front()};
  }
  return squares;
}

}  // namespace

bool shows_squares(const ImageView8& image, const JunctionGrid& grid) {
  const auto [columns, rows] = size_of(grid);
  const int all = (columns - 1) * (rows - 1);
  if (all == 1) return true;
  const Squares squares = squares_of(image, grid);
  if (static_cast<double>(squares.size()) <=
      std::min(policy::kMinSquaresShare * all, policy::kEnoughSquares))
    return false;
  // Sums over pairs: a square and the next one of the other colour, or of its own.
  double contrast = 0, contrast_aside = 0, spread = 0;
  int num_other = 0, num_own = 0;
  for (const auto& [cell, one] : squares) {
    for (const GridCell& step : {GridCell{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
      const auto next = squares.find({cell.first + step.first, cell.second + step.second});
      if (next == squares.end()) continue;
      if (step.first != 0 && step.second != 0) {
        spread += std::abs(one.middle - next->second.middle);
        ++num_own;
      } else {
        contrast += one.middle + next->second.middle;
        contrast_aside += one.aside + next->second.aside;
        ++num_other;
      }
    }
  }
  return contrast > 0 &&
         std::abs(contrast_aside - contrast) < policy::kMaxWithinSquareShare * contrast &&
         spread * num_other <= policy::kMaxLikeSquaresShare * contrast * num_own;
}

}  // namespace tagcal::internal
