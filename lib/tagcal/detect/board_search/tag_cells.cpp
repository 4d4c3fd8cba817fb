#include "tagcal/detect/board_search/tag_cells.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/detect/board_search/cell_levels.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/print/printed_tag.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

using namespace policy;

using Values = std::vector<double>;

// numeric: Gauss-Legendre's two places of an integral, for the mean level over a cell: 1 / sqrt(12)
// cells from its centre.
constexpr double kSampleOffset = 0.2887;
constexpr double kStepCells = 1.0 / 2;  // of the search for the quad with the highest correlation
constexpr double kLastStepPx = 0.2;     // numeric: smaller steps are left to the fit
constexpr int kEnoughCells =
    8;  // of border and frame for a plane of levels, which has three numbers
constexpr std::size_t kSweeps = 3;  // over all corners, for each step
// Information about slopes and level of a plane of grey levels that is always there.
constexpr double kSlopeInformation = 1e-3;  // numeric: holds slopes that the cells do not determine
constexpr double kLevelInformation = 1e-9;  // numeric: keeps the system regular without cells

// Pixels from cells, the origin at the tag's centre.
std::optional<Matrix3d> pixels_from_cells(const Quad& quad, double width_at_border) {
  const double h = width_at_border / 2;
  const Vector2d points[4] = {{-h, h}, {h, h}, {h, -h}, {-h, -h}};
  const Vector2d middle = centre_of(quad);
  Vector3d rays[4];
  for (std::size_t i = 0; i < 4; ++i) rays[i] = (quad[i] - middle).homogeneous();
  std::optional<Matrix3d> h_middle = homography(points, rays);
  if (h_middle) h_middle->topRows<2>() += middle * h_middle->row(2);
  return h_middle;
}

double correlation(const Values& levels, const TagCells& pattern) {
  double n = 0, white = 0, sum = 0, squares = 0, product = 0;
  for (int y = 0; y < pattern.width(); ++y) {
    for (int x = 0; x < pattern.width(); ++x) {
      const TagCells::Cell& cell = pattern.cell(x, y);
      if (cell.part == TagCells::Part::unknown) continue;
      const double level = levels[static_cast<std::size_t>(y * pattern.width() + x)];
      n += 1;
      white += cell.white;
      sum += level;
      squares += level * level;
      product += cell.white * level;
    }
  }
  const double variance = squares - sum * sum / n;
  const double of_pattern = white - white * white / n;
  if (!(variance > n) || !(of_pattern > 0)) return 0;  // sd below one grey level
  return (product - white * sum / n) / std::sqrt(variance * of_pattern);
}

double pattern_correlation(const ImageView8& image, const Quad& quad, const TagCells& pattern,
                           double spread) {
  if (!is_face(quad)) return -1;
  const auto pixels = pixels_from_cells(quad, pattern.width_at_border());
  if (!pixels) return -1;
  return correlation(cell_levels(image, *pixels, pattern.width(), spread), pattern);
}

Quad moved(const Quad& quad, const Vector2d& by) {
  Quad result = quad;
  for (Vector2d& corner : result) corner += by;
  return result;
}

// The quad with the highest correlation of those that were tried.
class QuadSearch {
 public:
  // `spread`: cells, from a cell's centre to its samples.
  QuadSearch(const ImageView8& image, const TagCells& pattern, double spread, const Quad& start)
      : image_(image),
        pattern_(pattern),
        spread_(spread),
        best_(start),
        highest_(pattern_correlation(image, start, pattern, spread)) {}

  const Quad& best() const { return best_; }
  double highest() const { return highest_; }

  void try_at(const Quad& quad) {
    const double here = pattern_correlation(image_, quad, pattern_, spread_);
    if (!(here > highest_)) return;
    highest_ = here;
    best_ = quad;
  }

 private:
  ImageView8 image_;
  const TagCells& pattern_;
  double spread_;
  Quad best_;
  double highest_;
};

// The quad moved as a whole to the highest correlation, within `reach` cells.
Quad best_moved_quad(const ImageView8& image, const Quad& start, const TagCells& pattern,
                     double reach) {
  const double cells = pattern.width_at_border();
  const Vector2d across = (start[1] - start[0] + start[2] - start[3]) / (2 * cells);
  const Vector2d down = (start[0] - start[3] + start[1] - start[2]) / (2 * cells);
  const int steps = static_cast<int>(std::floor(reach / kStepCells));
  QuadSearch search(image, pattern, 0, start);
  for (int y = -steps; y <= steps; ++y)
    for (int x = -steps; x <= steps; ++x)
      search.try_at(moved(start, kStepCells * (x * across + y * down)));
  return search.best();
}

// Moves a corner by one step in the best of four directions. False if none is better.
bool improve_corner(std::size_t i, double step_px, QuadSearch& search) {
  const Quad before = search.best();
  const double highest = search.highest();
  for (const Vector2d& way : {Vector2d(1, 0), Vector2d(-1, 0), Vector2d(0, 1), Vector2d(0, -1)}) {
    Quad there = before;
    there[i] += step_px * way;
    search.try_at(there);
  }
  return search.highest() > highest;
}

// A plane of grey levels over the cells, with its origin at the pattern's centre.
class LevelPlane {
 public:
  void add(double x, double y, double level) {
    const Vector3d row(x, y, 1);
    information_ += row * row.transpose();
    gradient_ += level * row;
    ++count_;
  }
  int count() const { return count_; }
  void fit() { plane_ = information_.ldlt().solve(gradient_); }
  double at(double x, double y) const { return plane_.dot(Vector3d(x, y, 1)); }

 private:
  Matrix3d information_ =
      Vector3d(kSlopeInformation, kSlopeInformation, kLevelInformation).asDiagonal();
  Vector3d gradient_ = Vector3d::Zero();
  Vector3d plane_ = Vector3d::Zero();
  int count_ = 0;
};

// Each cell's level plus a share of its difference from its neighbours, as AprilTag does.
Values sharpened(const Values& levels, int width) {
  Values result = levels;
  for (int y = 0; y < width; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      int count = 0;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (x + dx < 0 || y + dy < 0 || x + dx >= width || y + dy >= width) continue;
        sum += levels[static_cast<std::size_t>((y + dy) * width + x + dx)];
        ++count;
      }
      const auto i = static_cast<std::size_t>(y * width + x);
      result[i] += kTagDecodeSharpening * (count * levels[i] - sum);
    }
  }
  return result;
}

struct Levels {
  LevelPlane black;
  LevelPlane white;
};

Levels fitted_levels(const Values& levels, const TagCells& pattern) {
  Levels result;
  const double middle = (pattern.width() - 1) / 2.0;
  const auto add = [&](TagCells::Part part, bool colour, LevelPlane& plane) {
    for (int y = 0; y < pattern.width(); ++y) {
      for (int x = 0; x < pattern.width(); ++x) {
        const TagCells::Cell& cell = pattern.cell(x, y);
        if (cell.part != part || cell.white != colour) continue;
        plane.add(x - middle, y - middle,
                  levels[static_cast<std::size_t>(y * pattern.width() + x)]);
      }
    }
  };
  for (const auto& [plane, colour] : {std::pair{&result.black, false}, {&result.white, true}}) {
    add(TagCells::Part::fixed, colour, *plane);
    if (plane->count() < kEnoughCells) add(TagCells::Part::bit, colour, *plane);
    plane->fit();
  }
  return result;
}

}  // namespace

TagCells::TagCells(const TagFamily& family, int id, const CellSurroundings& surroundings)
    : width_(family.total_width),
      border_(family.width_at_border),
      cells_(static_cast<std::size_t>(width_ * width_), Cell{false, Part::fixed}) {
  const PrintedTag printed = printed_tag(family, id);
  for (int y = 0; y < width_; ++y)
    for (int x = 0; x < width_; ++x)
      at(x, y) = {!printed.is_black(x, y),
                  is_determined(family, x - start(), y - start()) ? Part::fixed : Part::unknown};
  const int ring = start() - (family.reversed_border ? 0 : 1);
  const bool framed = family.reversed_border || surroundings.white_frame;
  for (int i = ring; i < width_ - ring; ++i) {
    for (const auto& [x, y] :
         {std::pair{i, ring}, {i, width_ - 1 - ring}, {ring, i}, {width_ - 1 - ring, i}}) {
      at(x, y).part = framed ? Part::fixed : Part::unknown;
    }
  }
  if (!family.reversed_border && surroundings.corner_squares) {
    for (const int x : {0, width_ - 1})
      for (const int y : {0, width_ - 1}) at(x, y).part = Part::unknown;
  }
  for (const TagFamily::Cell& bit : family.bits)
    at(bit.x + start(), bit.y + start()).part = Part::bit;
}

TagAnswer read_tag(const ImageView8& image, const Quad& quad, const TagCells& pattern) {
  TagAnswer answer;
  const auto pixels = pixels_from_cells(quad, pattern.width_at_border());
  if (!pixels) return answer;
  const int width = pattern.width();
  const Values raw = cell_levels(image, *pixels, width, kSampleOffset);
  const Values levels = sharpened(cell_levels(image, *pixels, width, 0), width);
  const Levels planes = fitted_levels(raw, pattern);
  const double middle = (width - 1) / 2.0;
  answer.contrast = planes.white.at(0, 0) - planes.black.at(0, 0);
  int fixed = 0, wrong = 0;
  for (int y = 0; y < width; ++y) {
    for (int x = 0; x < width; ++x) {
      const TagCells::Cell& cell = pattern.cell(x, y);
      const double threshold =
          (planes.black.at(x - middle, y - middle) + planes.white.at(x - middle, y - middle)) / 2;
      const bool agrees =
          (levels[static_cast<std::size_t>(y * width + x)] > threshold) == cell.white;
      if (cell.part == TagCells::Part::bit) answer.wrong_bits += !agrees;
      if (cell.part != TagCells::Part::fixed) continue;
      ++fixed;
      wrong += !agrees;
    }
  }
  answer.wrong_fixed = static_cast<double>(wrong) / std::max(1, fixed);
  return answer;
}

double pattern_correlation(const ImageView8& image, const Quad& quad, const TagCells& pattern) {
  return pattern_correlation(image, quad, pattern, kSampleOffset);
}

Quad best_correlated_quad(const ImageView8& image, const Quad& start, const TagCells& pattern,
                          double reach, double last_step_cells) {
  Quad quad = best_moved_quad(image, start, pattern, reach);
  const double cell_px = shortest_side(start) / pattern.width_at_border();
  for (double step = kStepCells; step * cell_px > kLastStepPx && step > last_step_cells;
       step /= 2) {
    // Smaller steps need samples nearer to the cells' edges, as far as these are sharp.
    const double edge = std::max(step, 1 / cell_px);
    QuadSearch search(image, pattern, std::max(kSampleOffset, 1.0 / 2 - edge), quad);
    int stuck = 0;  // corners that have been tried since the last move
    for (std::size_t i = 0; i < 4 * kSweeps && stuck < 4; ++i)
      stuck = improve_corner(i % 4, step * cell_px, search) ? 0 : stuck + 1;
    quad = search.best();
  }
  return quad;
}

}  // namespace tagcal::internal
