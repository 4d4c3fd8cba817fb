#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/detect/refine_tag_axis.hpp"

// Private to detect: the model that refine_tag() fits.
namespace tagcal {

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
constexpr int kBend = 13;       // four of second order, then eight of third
constexpr int kNumBends = 12;
constexpr int kCount = 25;
}  // namespace tag_parameter

using TagParameters = Eigen::Matrix<double, tag_parameter::kCount, 1>;

// Displacements of second order that no homography makes, and of third order, by which a pixel is
// moved before it meets the homography.
using BendBasis = Eigen::Matrix<double, 2, tag_parameter::kNumBends>;
inline BendBasis bend_basis(double x, double y) {
  const double xx = x * x, xy = x * y, yy = y * y;
  BendBasis basis;
  basis << yy, 0, xx, xy, x * xx, x * xy, x * yy, y * yy, 0, 0, 0, 0,  //
      0, xx, -xy, -yy, 0, 0, 0, 0, x * xx, x * xy, x * yy, y * yy;
  return basis;
}

// What the model says of a pixel: its share of white, and that by the bent place. Then the lines'
// distances in spreads times white by them, with the products of their normals: a change A of the
// places about the pixel changes the distances by so much less, as lines keep theirs in px; the
// negative trace is white by the log of the spread.
struct TagPixel {
  float white = 0;
  float by_x = 0;
  float by_y = 0;
  float about_xx = 0;
  float about_xy = 0;
  float about_yy = 0;
};

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
  TagModel(const TagGrid& grid, double scale);

  void set(const TagParameters& parameters);
  const TagParameters& parameters() const { return parameters_; }
  double spread() const { return spread_; }

  // Turns to a row: shrinks [begin, end) to the pixels at least `reach` spreads from the unknown.
  void set_row(const TagRow& row, double reach, int& begin, int& end);
  RowPlaces places() const;  // of the row, bent

  // What reaches pixel c of the row.
  enum class Seen { black, white, both, unknown };
  Seen seen(int c) const;
  TagPixel evaluate(int c) const;

 private:
  // Of the series for the integral over a quadrant: by powers of the correlation.
  static constexpr int kMaxTerms = 16;
  struct Junction {
    float contrast = 0;  // mixed difference of the four cells
    int num_terms = 0;
    std::array<float, kMaxTerms> term{};
  };
  // The lines of one direction that are felt at a pixel, and white by their distances.
  struct Felt {
    int first = 0;
    int count = 0;
    std::array<float, kMaxTagLines> distance, density, slope, by_distance;
    std::array<float, kMaxTagLines + 1> weight;  // of the cells between
  };

  void set_axis(TagAxis& axis, int row_of_m);
  void set_junctions();
  void feel(const TagAxis& axis, int c, Felt& felt) const;
  float blend(Felt& columns, Felt& rows) const;
  float junctions(Felt& columns, Felt& rows) const;
  void differentiate(const TagAxis& axis, int c, const Felt& felt, TagPixel& pixel) const;
  void bend_row(int begin, int end);

  double scale_;
  int num_columns_;  // of cells
  int num_rows_;
  std::vector<std::uint32_t> cells_;    // per row of cells, bit i: cell i is white
  std::vector<std::uint32_t> unknown_;  // likewise
  std::vector<float> whites_;           // 1 where a cell is white, row by row
  TagAxis columns_;
  TagAxis rows_;
  std::vector<Junction> junctions_;
  TagParameters parameters_;
  double spread_ = 1;
  TagRow row_;
  std::vector<float> bent_x_, bent_y_;  // of the row's pixels
  double bulge_ = 0;
};

}  // namespace tagcal
