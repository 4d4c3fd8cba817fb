#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "tagcal/detect/refine_tag.hpp"

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
constexpr int kBend = 13;
constexpr int kCount = 17;
}  // namespace tag_parameter

using TagParameters = Eigen::Matrix<double, tag_parameter::kCount, 1>;

// Displacements of second order that no homography makes, by which a pixel is moved before it meets
// the homography.
inline Eigen::Matrix<double, 2, 4> bend_basis(double x, double y) {
  Eigen::Matrix<double, 2, 4> basis;
  basis << y * y, 0, x * x, x * y, 0, x * x, -x * y, -y * y;
  return basis;
}

constexpr int kMaxTagLines = 24;

// The borders of the cells in one direction, as lines in the image, and those of them that are near
// to the pixel at hand.
struct TagAxis {
  struct Line {
    double at = 0;  // on the tag
    Eigen::Vector2d normal = Eigen::Vector2d::Zero();
    double inv_length = 0;  // of the line's normal part
    double inv_spread = 0;  // h = inv_spread (numerator - at w): distance in spreads
    double box = 0;         // fourth cumulant of the pixel's square over 24 spread^4
  };
  std::vector<Line> lines;

  int cell = 0;   // that the pixel is in
  int first = 0;  // active lines [first, first + count)
  int count = 0;
  std::array<double, kMaxTagLines> h;        // per active line
  std::array<double, kMaxTagLines> density;  // normal, at h
  std::array<double, kMaxTagLines> normal;   // its integral
  std::array<double, kMaxTagLines> slope;    // of the step's profile
  std::array<double, kMaxTagLines + 1> weight;  // of the cells about them, from first - 1

  // False where what is not known reaches the pixel.
  bool approach(double numerator, double w);
  void weigh();
};

// What the model says of a pixel.
struct TagPixel {
  double white = 0;  // share of white
  std::array<float, tag_parameter::kCount> by_parameter{};
};

class TagModel {
 public:
  enum class Pixel { unknown, flat, graded };

  TagModel(const TagPattern& pattern, double scale);

  void set(const TagParameters& parameters);
  const TagParameters& parameters() const { return parameters_; }
  double spread() const { return spread_; }

  // For a pixel at (x, y) in the units of the parameters. Derivatives are filled where `graded`.
  Pixel evaluate(double x, double y, TagPixel& pixel);

 private:
  // An order of quadrature for the integral over the correlation (Drezner & Wesolowsky 1990).
  static constexpr int kNodes = 4;
  struct Junction {
    double contrast = 0;  // mixed difference of the four cells
    double correlation = 0;
    double inv_root = 1;  // 1 / sqrt(1 - correlation^2)
    std::array<double, kNodes> node{}, decay{}, weight{};
  };

  void set_axis(TagAxis& axis, int row_of_m);
  void set_junctions();
  bool is_flat() const;
  void blend(TagPixel& pixel);
  void add_junctions(TagPixel& pixel);
  void add_junction(const Junction& junction, int i, int j);
  void differentiate(double x, double y, TagPixel& pixel) const;
  double cell(int column, int row) const {
    return cells_[static_cast<std::size_t>(row * num_cells_ + column)];
  }

  double scale_;
  int num_cells_;
  std::vector<double> cells_;
  TagAxis columns_;
  TagAxis rows_;
  std::vector<Junction> junctions_;
  TagParameters parameters_;
  double spread_ = 1;

  // Of the pixel at hand: its bent place, the derivatives of white by the active lines' h and by
  // their direction.
  Eigen::Vector2d place_;
  std::array<double, kMaxTagLines> by_column_;
  std::array<double, kMaxTagLines> by_row_;
  std::array<Eigen::Vector2d, kMaxTagLines> turn_column_;
  std::array<Eigen::Vector2d, kMaxTagLines> turn_row_;
};

}  // namespace tagcal
