#include "tagcal/detect/refine_tag_moments.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cstddef>

namespace tagcal {
namespace {

using namespace tag_parameter;
using Eigen::Matrix3d;

// Derivatives of m by the generators: p -> p + (1, 0), (x, 0), (y, 0), (0, 1), (0, x), (0, y),
// (xx, xy), (xy, yy).
Eigen::Matrix<double, 8, 8> m_by_generators(const TagParameters& at) {
  Matrix3d m;
  m << at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7], 1;
  constexpr std::array<std::array<int, 2>, 8> kEntries = {
      {{0, 2}, {0, 0}, {0, 1}, {1, 2}, {1, 0}, {1, 1}, {2, 0}, {2, 1}}};
  Eigen::Matrix<double, 8, 8> result;
  for (int k = 0; k < 8; ++k) {
    const auto [row, column] = kEntries[static_cast<std::size_t>(k)];
    Matrix3d change = Matrix3d::Zero();
    change.col(column) = (row == 2 ? -1 : 1) * m.col(row);
    change -= change(2, 2) * m;
    for (int i = 0; i < 8; ++i) result(i, k) = change(i / 3, i % 3);
  }
  return result;
}

}  // namespace

void GradedRow::reserve(int count) {
  const auto padded = static_cast<std::size_t>(count + kTagPack);
  if (x.size() >= padded) return;
  for (std::vector<float>* values :
       {&x, &by_x, &by_y, &about_xx, &about_xy, &about_yy, &white, &residual, &place_x, &place_y})
    values->resize(padded);
}

void GradedRow::add(double at, double gain, const TagPixel& pixel, float of_pixel) {
  const auto k = static_cast<std::size_t>(size++);
  const auto g = static_cast<float>(gain);
  x[k] = static_cast<float>(at);
  by_x[k] = g * pixel.by_x;
  by_y[k] = g * pixel.by_y;
  about_xx[k] = g * pixel.about_xx;
  about_xy[k] = g * pixel.about_xy;
  about_yy[k] = g * pixel.about_yy;
  white[k] = pixel.white;
  residual[k] = of_pixel;
}

void GradedRow::end() {
  const auto first = static_cast<std::size_t>(size);
  for (std::vector<float>* values :
       {&x, &by_x, &by_y, &about_xx, &about_xy, &about_yy, &white, &residual, &place_x, &place_y})
    std::fill_n(values->begin() + static_cast<std::ptrdiff_t>(first), kTagPack, 0.0F);
}

void TagMoments::start(Kind kind) {
  kind_ = kind;
  for (auto& sums : sums_) sums.fill(0);
  set_columns();
}

void TagMoments::set_columns() {
  const bool placed = kind_ == Kind::placed;
  num_powers_ = kind_ == Kind::bent ? 4 : 3;
  first_level_ = placed ? 9 : 2 * num_powers_ + 6;
  const int white = first_level_, white_x = white + 1;
  // Where places are no longer even along a row, white times y is a vector of its own.
  const int white_y = placed ? white + 2 : white, residual = white + (placed ? 3 : 2);
  num_vectors_ = residual + 2;
  columns_[kBlack] = {{{{residual + 1, 0, 1}}}};
  columns_[kGain] = {{{{white, 0, 1}}}};
  columns_[kGainSlope] = {{{{white_x, 0, 1}}}};
  columns_[kGainSlope + 1] = {{{{white_y, placed ? 0 : 1, 1}}}};
  columns_[kCount] = {{{{residual, 0, 1}}}};
  powers_of_y_.fill(0);
  if (!placed) return set_geometry();
  for (int i = 0; i < kBlack; ++i) columns_[static_cast<std::size_t>(i)] = {{{{i, 0, 1}}}};
}

void TagMoments::set_geometry() {
  const int y = num_powers_, order = num_powers_ - 1;  // the first vector of levels by y
  const int xx = 2 * num_powers_, xy = xx + 1, yy = xx + 2;
  const int x_xx = xx + 3, x_xy = xx + 4, x_yy = xx + 5;
  columns_[0] = {{{{0, 0, 1}}}};
  columns_[1] = {{{{1, 0, 1}, {xx, 0, -1}}}, 2};
  columns_[2] = {{{{0, 1, 1}, {xy, 0, -1}}}, 2};
  columns_[3] = {{{{y, 0, 1}}}};
  columns_[4] = {{{{y + 1, 0, 1}, {xy, 0, -1}}}, 2};
  columns_[5] = {{{{y, 1, 1}, {yy, 0, -1}}}, 2};
  columns_[6] = {{{{2, 0, 1}, {y + 1, 1, 1}, {x_xx, 0, -2}, {xy, 1, -1}, {x_yy, 0, -1}}}, 5};
  columns_[7] = {{{{1, 1, 1}, {y, 2, 1}, {xx, 1, -1}, {x_xy, 0, -1}, {yy, 1, -2}}}, 5};
  columns_[kLogSpread] = {{{{xx, 0, -1}, {yy, 0, -1}}}, 2};
  for (int i = 0; i < num_powers_; ++i)
    powers_of_y_[static_cast<std::size_t>(i)] = powers_of_y_[static_cast<std::size_t>(i + y)] =
        2 * order - i;
  for (int i = xx; i < num_vectors_; ++i) powers_of_y_[static_cast<std::size_t>(i)] = order + 1;
  if (kind_ == Kind::straight) return;
  const std::array<Column, kNumBends> bends = {{{{{{0, 2, 1}}}},
                                                {{{{y + 2, 0, 1}}}},
                                                {{{{2, 0, 1}, {y + 1, 1, -1}}}, 2},
                                                {{{{1, 1, 1}, {y, 2, -1}}}, 2},
                                                {{{{3, 0, 1}}}},
                                                {{{{2, 1, 1}}}},
                                                {{{{1, 2, 1}}}},
                                                {{{{0, 3, 1}}}},
                                                {{{{y + 3, 0, 1}}}},
                                                {{{{y + 2, 1, 1}}}},
                                                {{{{y + 1, 2, 1}}}},
                                                {{{{y, 3, 1}}}}}};
  std::copy(bends.begin(), bends.end(), columns_.begin() + kBend);
}

void TagMoments::add(const GradedRow& row) {
  if (row.size == 0) return;
  const int padded = (row.size + kTagPack - 1) / kTagPack * kTagPack;
  const int count = num_vectors_ + num_vectors_ % 2;
  if (stride_ < padded) {
    stride_ = 2 * padded;
    vectors_.assign(static_cast<std::size_t>((kTagGramRows + 2) * stride_), 0);
  }
  set_vectors(row, padded);
  Products products;
  fastest_tag_kernels().gram(vectors_.data(), stride_, count, padded, products.data());
  const auto y = row.y;
  for (int i = 0; i < num_vectors_; ++i) {
    const auto first = static_cast<std::size_t>(i * kTagGramRows);
    double power = 1;
    for (int k = 0; k <= powers_of_y_[static_cast<std::size_t>(i)]; ++k, power *= y) {
      double* const sums = sums_[static_cast<std::size_t>(k)].data() + first;
      for (int j = 0; j <= (i | 3); ++j)
        sums[j] += power * static_cast<double>(products[first + static_cast<std::size_t>(j)]);
    }
  }
}

// What is beyond the row's size is zero, as the level's derivatives are there.
void TagMoments::set_vectors(const GradedRow& row, int padded) {
  if (kind_ == Kind::placed)
    set_generators(row, padded);
  else
    set_powers(row, padded);
  set_levels(row, padded);
}

void TagMoments::set_powers(const GradedRow& row, int padded) {
  float* vector = vectors_.data();
  for (const std::vector<float>* by : {&row.by_x, &row.by_y}) {
    std::copy_n(by->data(), padded, vector);
    for (int k = 1; k < num_powers_; ++k, vector += stride_)
      for (int c = 0; c < padded; ++c)
        vector[stride_ + c] = vector[c] * row.x[static_cast<std::size_t>(c)];
    vector += stride_;
  }
  for (const std::vector<float>* about : {&row.about_xx, &row.about_xy, &row.about_yy}) {
    std::copy_n(about->data(), padded, vector);
    for (int c = 0; c < padded; ++c)
      vector[3 * stride_ + c] = vector[c] * row.x[static_cast<std::size_t>(c)];
    vector += stride_;
  }
}

void TagMoments::set_generators(const GradedRow& row, int padded) {
  float* const v = vectors_.data();
  const float *const x = row.place_x.data(), *const y = row.place_y.data();
  for (int c = 0; c < padded; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const float by_x = row.by_x[k], by_y = row.by_y[k];
    const float xx = row.about_xx[k], xy = row.about_xy[k], yy = row.about_yy[k];
    const float radial = by_x * x[c] + by_y * y[c];
    v[c] = by_x;
    v[stride_ + c] = by_x * x[c] - xx;
    v[2 * stride_ + c] = by_x * y[c] - xy;
    v[3 * stride_ + c] = by_y;
    v[4 * stride_ + c] = by_y * x[c] - xy;
    v[5 * stride_ + c] = by_y * y[c] - yy;
    v[6 * stride_ + c] = radial * x[c] - x[c] * (2 * xx + yy) - y[c] * xy;
    v[7 * stride_ + c] = radial * y[c] - x[c] * xy - y[c] * (xx + 2 * yy);
    v[8 * stride_ + c] = -xx - yy;
  }
}

void TagMoments::set_levels(const GradedRow& row, int padded) {
  float* vector = vectors_.data() + first_level_ * stride_;
  const auto next = [&] {
    float* const result = vector;
    vector += stride_;
    return result;
  };
  const float* const white = row.white.data();
  std::copy_n(white, padded, next());
  float* const white_x = next();
  for (int c = 0; c < padded; ++c) white_x[c] = white[c] * row.x[static_cast<std::size_t>(c)];
  if (kind_ == Kind::placed) {
    float* const white_y = next();
    const auto y = static_cast<float>(row.y);
    for (int c = 0; c < padded; ++c) white_y[c] = white[c] * y;
  }
  std::copy_n(row.residual.data(), padded, next());
  float* const one = next();
  std::fill_n(one, row.size, 1.0F);
  std::fill_n(one + row.size, padded - row.size, 0.0F);
  std::fill_n(next(), padded, 0.0F);  // makes the count even
}

double TagMoments::product(const Column& a, const Column& b) const {
  double result = 0;
  for (int i = 0; i < a.count; ++i) {
    for (int j = 0; j < b.count; ++j) {
      const Term& s = a.terms[static_cast<std::size_t>(i)];
      const Term& t = b.terms[static_cast<std::size_t>(j)];
      const int row = std::max(s.vector, t.vector), column = std::min(s.vector, t.vector);
      const auto& sums = sums_[static_cast<std::size_t>(s.power + t.power)];
      result += s.factor * t.factor * sums[static_cast<std::size_t>(row * kTagGramRows + column)];
    }
  }
  return result;
}

TagMoments::Result TagMoments::result(const TagParameters& at) const {
  Result result;
  result.information.setIdentity();
  result.gradient.setZero();
  const Column& residual = columns_[kCount];
  result.squares = product(residual, residual);
  const int count = kind_ == Kind::bent ? kCount : kBend;
  for (int i = 0; i < count; ++i) {
    const Column& column = columns_[static_cast<std::size_t>(i)];
    result.gradient[i] = product(column, residual);
    for (int j = 0; j <= i; ++j)
      result.information(i, j) = result.information(j, i) =
          product(column, columns_[static_cast<std::size_t>(j)]);
  }
  const Eigen::Matrix<double, 8, 8> generators_by_m = m_by_generators(at).inverse();
  result.information.topRows<8>() =
      (generators_by_m.transpose() * result.information.topRows<8>()).eval();
  result.information.leftCols<8>() = (result.information.leftCols<8>() * generators_by_m).eval();
  result.gradient.head<8>() = (generators_by_m.transpose() * result.gradient.head<8>()).eval();
  return result;
}

}  // namespace tagcal
