#include "tagcal/detect/board_search/cell_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tagcal::internal {
namespace {

constexpr std::size_t kCellsAtOnce = 12;  // numeric: along a row, the width of Kalibr's tags
using CellValues = std::array<double, kCellsAtOnce>;

// Grey levels between the pixels of a picture, and beyond its edge those of the edge. Simple loops
// of fixed length, which compilers vectorise.
class LevelsAt {
 public:
  explicit LevelsAt(const ImageView8& image)
      : image_(image),
        last_x_(std::nextafter(image.width() - 1.0, 0.0)),
        last_y_(std::nextafter(image.height() - 1.0, 0.0)) {}

  CellValues operator()(const CellValues& x, const CellValues& y) const {
    CellValues u, v, levels;
    std::array<int, kCellsAtOnce> column, row, above, right, below, diagonal;
    for (std::size_t i = 0; i < kCellsAtOnce; ++i) {
      // In this order of arguments max takes 0 for a NaN.
      u[i] = std::min(std::max(0.0, x[i]), last_x_);
      v[i] = std::min(std::max(0.0, y[i]), last_y_);
      column[i] = static_cast<int>(u[i]), row[i] = static_cast<int>(v[i]);
    }
    for (std::size_t i = 0; i < kCellsAtOnce; ++i) {
      const std::uint8_t* const here = image_.row(row[i]) + column[i];
      const std::uint8_t* const under = here + image_.stride();
      above[i] = here[0], right[i] = here[1] - here[0];
      below[i] = under[0], diagonal[i] = under[1] - under[0];
    }
    for (std::size_t i = 0; i < kCellsAtOnce; ++i) {
      const double along = u[i] - column[i];
      const double upper = above[i] + along * right[i];
      levels[i] = upper + (v[i] - row[i]) * (below[i] + along * diagonal[i] - upper);
    }
    return levels;
  }

 private:
  ImageView8 image_;
  double last_x_, last_y_;
};

}  // namespace

std::vector<double> cell_levels(const ImageView8& image, const Eigen::Matrix3d& pixels, int width,
                                double spread) {
  const LevelsAt levels_at(image);
  std::vector<double> levels;
  levels.reserve(static_cast<std::size_t>(width * width));
  const Eigen::Vector3d across = pixels.col(0), down = pixels.col(1), middle = pixels.col(2);
  const double first = (1.0 - width) / 2;
  const std::size_t samples = spread == 0 ? 1 : 4;
  std::array<CellValues, 4> x, y;
  for (int row = 0; row < width; ++row) {
    for (int begin = 0; begin < width; begin += static_cast<int>(kCellsAtOnce)) {
      const double to_row = first + row, to_column = first + begin;
      for (std::size_t i = 0; i < kCellsAtOnce; ++i) {
        const double column = to_column + static_cast<double>(i);
        const auto at = [&](int k) { return column * across[k] + to_row * down[k] + middle[k]; };
        const double scale = 1 / at(2), at_x = scale * at(0), at_y = scale * at(1);
        for (std::size_t s = 0; s < 4; ++s) {
          const double u = (s % 2 == 0 ? -spread : spread) * scale;
          const double v = (s / 2 == 0 ? -spread : spread) * scale;
          x[s][i] = at_x + u * (across[0] - across[2] * at_x) + v * (down[0] - down[2] * at_x);
          y[s][i] = at_y + u * (across[1] - across[2] * at_y) + v * (down[1] - down[2] * at_y);
        }
      }
      CellValues sums{};
      for (std::size_t s = 0; s < samples; ++s) {
        const CellValues level = levels_at(x[s], y[s]);
        for (std::size_t i = 0; i < kCellsAtOnce; ++i) sums[i] += level[i];
      }
      for (std::size_t i = 0; i < kCellsAtOnce && begin + static_cast<int>(i) < width; ++i)
        levels.push_back(sums[i] / static_cast<double>(samples));
    }
  }
  return levels;
}

}  // namespace tagcal::internal
