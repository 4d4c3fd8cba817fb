#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "tagcal/detect/refine_tag_kernels.hpp"
#include "tagcal/detect/refine_tag_model.hpp"

// Private to detect: the normal equations of refine_tag().
namespace tagcal {

using TagInformation = Eigen::Matrix<double, tag_parameter::kCount, tag_parameter::kCount>;

// Pixels of a row that know of the geometry.
struct GradedRow {
  int size = 0;
  double y = 0;  // place of the row without a lens
  // Place, level by place, TagPixel's terms in levels, share of white, residual; the places of a
  // known lens.
  std::vector<float> x, by_x, by_y, about_xx, about_xy, about_yy, white, residual, place_x, place_y;

  void reserve(int count);
  void add(double at, double gain, const TagPixel& pixel, float residual);
  void end();  // zeros up to a whole pack
};

// Every geometric parameter moves the pixels by a polynomial in their place of up to third order:
// all products of derivatives are sums of few along a row, times powers of the row's place.
class TagMoments {
 public:
  enum class Kind {
    straight,  // a homography
    bent,      // and the bends
    placed     // a homography of places that a lens has straightened
  };

  // Forgets all rows.
  void start(Kind kind);
  void add(const GradedRow& row);

  struct Result {
    TagInformation information;  // of bends that are not free: one
    TagParameters gradient;
    double squares = 0;
  };
  Result result(const TagParameters& at) const;

 private:
  // Vectors: levels by x times powers of x (or by the generators of the homographies), by y
  // likewise and the terms about lines and these times x (or by the spread), then white, white
  // times x, residual, one.
  static constexpr int kMaxPower = 6;
  using Products = std::array<float, kTagGramRows * kTagGramRows>;
  struct Term {
    int vector = 0;
    int power = 0;  // of y
    double factor = 1;
  };
  struct Column {
    std::array<Term, 5> terms;
    int count = 1;
  };

  void set_columns();
  void set_geometry();
  void set_vectors(const GradedRow& row, int padded);
  void set_powers(const GradedRow& row, int padded);
  void set_generators(const GradedRow& row, int padded);
  void set_levels(const GradedRow& row, int padded);
  double product(const Column& a, const Column& b) const;

  Kind kind_ = Kind::straight;
  int num_powers_ = 3;    // of x
  int first_level_ = 12;  // vector that is white
  int num_vectors_ = 16;
  std::array<int, kTagGramRows> powers_of_y_{};            // that are needed of a vector's products
  std::array<Column, tag_parameter::kCount + 1> columns_;  // the residual is the last
  std::vector<float> vectors_;
  int stride_ = 0;
  std::array<std::array<double, kTagGramRows * kTagGramRows>, kMaxPower + 1> sums_;
};

}  // namespace tagcal
