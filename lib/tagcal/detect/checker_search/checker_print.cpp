#include "tagcal/detect/checker_search/checker_print.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/scene/print/printed_tag.hpp"

namespace tagcal::internal {
namespace {

// The cells within a marker's border and the border, row by row from above.
std::vector<TagPattern::Cell> marker_cells(const TagFamily& family, int id) {
  const auto n = static_cast<std::size_t>(family.width_at_border);
  if (id < 0 || static_cast<std::size_t>(id) >= family.codes.size() || family.reversed_border)
    return std::vector<TagPattern::Cell>(n * n, TagPattern::unknown);
  const PrintedTag printed = printed_tag(family, id);
  const int frame = (family.total_width - family.width_at_border) / 2;
  std::vector<TagPattern::Cell> cells;
  for (int y = frame; y < frame + family.width_at_border; ++y)
    for (int x = frame; x < frame + family.width_at_border; ++x)
      cells.push_back(printed.is_black(x, y) ? TagPattern::black : TagPattern::white);
  return cells;
}

constexpr double kHalf = 1.0 / 2;  // of a square

}  // namespace

CheckerPrint::CheckerPrint(const Board& board) {
  const Checkerboard squares = checkers(board).value();
  columns_ = squares.columns;
  rows_ = squares.rows;
  starts_black_ = squares.starts_black;
  const auto markers = tag_kind(board);
  if (!markers) return;
  const TagFamily family = tag_family(markers->family, markers->border_bits);
  const double side = squares.column_spacing;
  marker_cells_ = family.width_at_border;
  for (const Tag& tag : tags_of(board)) {
    marker_side_ = tag.size / side;
    const Eigen::Vector3d centre = tag.board_from_tag.translation() / side;
    const CheckerCell square{static_cast<int>(std::lround(centre.x() + kHalf)),
                             static_cast<int>(std::lround(centre.y() + kHalf))};
    markers_[square] = marker_cells(family, tag.id);
  }
}

bool CheckerPrint::is_at_edge(const CheckerCell& corner) const {
  return corner.first == 0 || corner.second == 0 || corner.first == columns_ - 1 ||
         corner.second == rows_ - 1;
}

// The lines of one direction about a corner. Markers have more lines than a fit takes, unless it
// ends at the next corners.
std::vector<double> CheckerPrint::lines(int corner, int count, double outside) const {
  const double beyond = markers_.empty() ? policy::kCheckerBeyond : 0;
  std::vector<double> result = {0};
  const double low = corner > 0 ? 1 : outside, high = corner < count - 1 ? 1 : outside;
  result.push_back(-low);
  result.push_back(high);
  if (beyond > 0 && corner > 0) result.push_back(-1 - beyond);
  if (beyond > 0 && corner < count - 1) result.push_back(1 + beyond);
  if (!markers_.empty()) {
    for (const double middle : {-kHalf, kHalf}) {
      for (int k = 0; k <= marker_cells_; ++k) {
        const double at = middle + marker_side_ * (static_cast<double>(k) / marker_cells_ - kHalf);
        if (-low < at && at < high) result.push_back(at);
      }
    }
  }
  std::ranges::sort(result);
  return result;
}

TagPattern::Cell CheckerPrint::colour(double x, double y) const {
  const CheckerCell square{static_cast<int>(std::floor(x)) + 1,
                           static_cast<int>(std::floor(y)) + 1};
  if (((square.first + square.second) % 2 == 0) == starts_black_) return TagPattern::black;
  const auto marker = markers_.find(square);
  if (marker == markers_.end()) return TagPattern::white;
  const double u = (x - square.first + kHalf) / marker_side_ + kHalf;
  const double v = kHalf - (y - square.second + kHalf) / marker_side_;
  if (u <= 0 || v <= 0 || u >= 1 || v >= 1) return TagPattern::white;
  const auto column = static_cast<std::size_t>(u * marker_cells_);
  const auto row = static_cast<std::size_t>(v * marker_cells_);
  return marker->second[row * static_cast<std::size_t>(marker_cells_) + column];
}

CornerPattern CheckerPrint::about(const CheckerCell& corner, double outside) const {
  CornerPattern pattern;
  pattern.columns = lines(corner.first, columns_, outside);
  pattern.rows = lines(corner.second, rows_, outside);
  for (std::size_t j = 0; j + 1 < pattern.rows.size(); ++j)
    for (std::size_t i = 0; i + 1 < pattern.columns.size(); ++i)
      pattern.cells.push_back(
          colour(corner.first + (pattern.columns[i] + pattern.columns[i + 1]) / 2,
                 corner.second + (pattern.rows[j] + pattern.rows[j + 1]) / 2));
  return pattern;
}

}  // namespace tagcal::internal
