#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "tagcal/detect/tag_fit/straight_view.hpp"
#include "tagcal/detect/tag_fit/tag_kernels.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect: the model that refine_tag() fits.
namespace tagcal::internal {

// Indices of the parameters. A place on the tag is u = (m1 p) / (m3 p), v = (m2 p) / (m3 p), with
// p = (x, y, 1) the bent place of a pixel, from the tag's middle in units of `scale` px; the last
// entry of m3 is 1.
namespace tag_parameter {
constexpr int kM1 = 0;
constexpr int kM2 = 3;
constexpr int kM3 = 6;
constexpr int kLogSpread = 8;  // logarithm of the sd of blur and pixel square together, px
constexpr int kBlack = 9;
constexpr int kGain = 10;
constexpr int kGainSlope = 11;  // by x and y
constexpr int kShift = 13;      // of borders towards black, px: bloom, then ink
constexpr int kBend = 15;       // four of second order, then eight of third
constexpr int kNumBends = 12;
constexpr int kCount = 27;
}  // namespace tag_parameter

// Those after the homography's (TagFitRest).
constexpr int kNumRest = tag_parameter::kCount - tag_parameter::kLogSpread;
using TagRest = Eigen::Matrix<double, kNumRest, 1>;

using TagParameters = Eigen::Matrix<double, tag_parameter::kCount, 1>;

// Displacements of a place before the homography: of second order, as far as no homography makes
// them, and of third order. If a lens is known, they start from the straightened place.
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
  // Straightened places of the pixels if the lens is known; they replace the above.
  RowPlaces straight;
};

// The part of a pattern that is fitted.
struct TagGrid {
  std::vector<double> columns, rows;    // lines between the cells; all beyond them is unknown
  std::vector<TagPattern::Cell> cells;  // (columns - 1) x (rows - 1), row by row
};

class TagModel {
 public:
  // Grey level = light^gamma.
  TagModel(const TagGrid& grid, double scale, double gamma = 1);
  // The ends of the levels' range, at which they are clipped (TagTable).
  void set_range(float least, float full, float beyond = 0);
  // As many lines of the same pattern at other places.
  void set_lines(const TagGrid& grid);

  void set(const TagParameters& parameters);
  const TagParameters& parameters() const { return parameters_; }
  double spread() const { return spread_; }

  // Selects pixels [begin, end) of a row, of the given levels: those at least `reach` spreads
  // inside the outermost lines, beyond which the pattern is unknown. Adds pixels of one colour to
  // the sums of black and of white; those of third and fourth order if terms of light need them.
  void select(const TagRow& row, const float* levels, double reach, int begin, int end,
              TagFlatSums* flat, bool has_light = false);

  // What is known of pixel c of the row (kSeen..).
  std::int32_t seen(int c) const { return seen_[static_cast<std::size_t>(c)]; }

  // Evaluation of pixels in blocks, which may mix rows: add() appends `count` pixels of the row
  // from c on, the first with an index in the patch; evaluate() computes share of white and
  // derivatives of all, add_ends() sums over those of one colour, at ends of the range, that the
  // model does not clip.
  void add(TagBlock& block, int c, int count, int in_patch) const;
  void add_ends(const TagBlock& block, bool white, TagFlatSums& flat) const;
  void evaluate(TagBlock& block, TagDerivatives& derivatives);

 private:
  void set_axis(TagAxis& axis, const std::vector<double>& lines, int row_of_m) const;
  double largest_cosine(const Eigen::Matrix2d& squares) const;
  void set_num_terms(double largest_cosine);

  double scale_;
  double gamma_;
  std::vector<double> column_lines_, row_lines_;  // on the tag
  TagParameters parameters_;
  double spread_ = 1;
  TagTable table_{};
  TagPixelRow row_{};
  // By pixels of the row:
  std::vector<float> x_, y_;
  std::vector<std::int32_t> columns_, rows_, num_felt_, seen_;
};

}  // namespace tagcal::internal
