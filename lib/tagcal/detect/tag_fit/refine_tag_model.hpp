#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "tagcal/detect/tag_fit/refine_tag_kernels.hpp"
#include "tagcal/detect/tag_fit/refine_tag_lens.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect: the model that refine_tag() fits.
namespace tagcal::internal {

// Where each parameter stands. The tag's plane from the image's is u = (m1 p) / (m3 p), v = (m2 p)
// / (m3 p), p = (x, y, 1) with x, y the bent place of a pixel, from the tag's middle in units of
// `scale` px; the last entry of m3 is 1.
namespace tag_parameter {
constexpr int kM1 = 0;
constexpr int kM2 = 3;
constexpr int kM3 = 6;
constexpr int kLogSpread = 8;  // of the sd of blur and pixel square together, px
constexpr int kBlack = 9;
constexpr int kGain = 10;
constexpr int kGainSlope = 11;  // along x and y
constexpr int kShift = 13;      // of borders towards black, px: in the picture, on the tag
constexpr int kBend = 15;       // four of second order, then eight of third
constexpr int kNumBends = 12;
constexpr int kCount = 27;
}  // namespace tag_parameter

using TagParameters = Eigen::Matrix<double, tag_parameter::kCount, 1>;

// Displacements of second order that no homography makes, and of third order, by which a pixel is
// moved before it meets the homography; where a lens is known, from where that puts it.
using BendBasis = Eigen::Matrix<double, 2, tag_parameter::kNumBends>;
inline BendBasis bend_basis(double x, double y) {
  const double xx = x * x, xy = x * y, yy = y * y;
  BendBasis basis;
  basis << yy, 0, xx, xy, x * xx, x * xy, x * yy, y * yy, 0, 0, 0, 0,  //
      0, xx, -xy, -yy, 0, 0, 0, 0, x * xx, x * xy, x * yy, y * yy;
  return basis;
}

// A row of pixels, in the units of the parameters: pixel c at (left + c step, y).
struct TagRow {
  double left = 0;
  double step = 1;
  double y = 0;
  // Where the pixels are without the lens, if it is known; else as above.
  RowPlaces straight;
};

// The part of a pattern that is fitted.
struct TagGrid {
  std::vector<double> columns, rows;    // borders of the cells; unknown beyond the outermost
  std::vector<TagPattern::Cell> cells;  // (columns - 1) x (rows - 1), row by row
};

class TagModel {
 public:
  // Grey is light to the power of gamma.
  TagModel(const TagGrid& grid, double scale, double gamma = 1);

  void set(const TagParameters& parameters);
  const TagParameters& parameters() const { return parameters_; }
  double spread() const { return spread_; }

  // Turns to a row: shrinks [begin, end) to the pixels at least `reach` spreads from what lies
  // beyond the outermost lines, which is not known.
  void set_row(const TagRow& row, double reach, int& begin, int& end);

  // What reaches pixel c of the row.
  enum class Seen { black, white, both, unknown };
  Seen seen(int c) const;

  // Pixels of any rows at once: empties a block, appends pixel c of the row, and says share of
  // white and derivatives of all.
  void start(TagBlock& block, bool is_bent, bool is_stretched) const;
  void add(TagBlock& block, int c, float level) const;
  // Where pixel c of the row is before it is bent.
  Eigen::Vector2f place(int c) const;
  void evaluate(TagBlock& block);

 private:
  void set_axis(TagAxis& axis, const std::vector<double>& lines, int row_of_m) const;
  double largest_cosine(const Eigen::Matrix2d& squares) const;
  void set_num_terms(double largest_cosine);
  void bend_row(int begin, int end);
  void bend_straight_row(const Eigen::Matrix<float, tag_parameter::kNumBends, 1>& bends, int begin,
                         int end);

  double scale_;
  double gamma_;
  std::vector<double> column_lines_, row_lines_;  // on the tag
  // Per row of cells, bit i: cell i is white; unknown. Then rows of zeros.
  std::array<std::uint32_t, 2 * kMaxTagLines> cells_{}, unknown_{};
  TagParameters parameters_;
  double spread_ = 1;
  TagTable table_{};
  TagRow row_;
  struct Felt {
    std::vector<std::int32_t> first, last;
  };
  Felt columns_, rows_;                 // of the row's pixels
  std::vector<std::int32_t> is_known_;  // likewise
  std::vector<float> bent_x_, bent_y_;  // likewise
};

}  // namespace tagcal::internal
