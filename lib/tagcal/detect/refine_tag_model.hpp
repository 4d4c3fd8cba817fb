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

// What the model says of a pixel.
struct TagPixel {
  float white = 0;  // share of white
  std::array<float, tag_parameter::kCount> by_parameter{};
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

  // What reaches pixel c of the row.
  enum class Seen { black, white, both, unknown };
  Seen seen(int c) const;
  void evaluate(int c, TagPixel& pixel);

 private:
  // Nodes of the quadrature for the integral over the correlation (Drezner & Wesolowsky 1990).
  static constexpr int kNodes = 4;
  struct Junction {
    float contrast = 0;  // mixed difference of the four cells
    float correlation = 0;
    float inv_root = 1;  // 1 / sqrt(1 - correlation^2)
    std::array<float, kNodes> node{}, decay{}, weight{};
    Eigen::Vector2f turn_column = Eigen::Vector2f::Zero();  // correlation by the lines' directions
    Eigen::Vector2f turn_row = Eigen::Vector2f::Zero();
  };
  // Of the pixel at hand: derivatives of white by the active lines' distances and directions.
  struct ByLines {
    std::array<float, kMaxTagLines> distance;
    std::array<Eigen::Vector2f, kMaxTagLines> turn;
  };

  void set_axis(TagAxis& axis, int row_of_m);
  void set_junctions();
  void blend(int c, TagPixel& pixel);
  void add_junctions(int c, TagPixel& pixel);
  void add_junction(const Junction& junction, int c, int column, int row, TagPixel& pixel);
  void differentiate(int c, TagPixel& pixel) const;
  void bend_row(int begin, int end);
  RowPlaces places() const;

  double scale_;
  int num_columns_;  // of cells
  int num_rows_;
  std::vector<std::uint32_t> cells_;    // per row of cells, bit i: cell i is white
  std::vector<std::uint32_t> unknown_;  // likewise
  TagAxis columns_;
  TagAxis rows_;
  std::vector<Junction> junctions_;
  TagParameters parameters_;
  double spread_ = 1;
  TagRow row_;
  std::vector<float> bent_x_, bent_y_;  // of the row's pixels
  double bulge_ = 0;
  ByLines by_columns_, by_rows_;
};

}  // namespace tagcal
