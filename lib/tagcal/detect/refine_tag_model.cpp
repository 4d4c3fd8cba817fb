#include "tagcal/detect/refine_tag_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tagcal {
namespace {

using Eigen::Vector2d;
using namespace tag_parameter;

constexpr double kBoxCumulant = -1.0 / 120;  // fourth, of the square of a pixel along a side
constexpr double kLeastTerm = 1e-3;  // of a quadrant's series; the sum of what is left is below a
                                     // twentieth of it

}  // namespace

TagModel::TagModel(const TagGrid& grid, double scale)
    : scale_(scale),
      num_columns_(static_cast<int>(grid.columns.size()) - 1),
      num_rows_(static_cast<int>(grid.rows.size()) - 1),
      cells_(grid.rows.size() - 1, 0),
      unknown_(grid.rows.size() - 1, 0),
      whites_(grid.cells.size()),
      columns_(grid.columns),
      rows_(grid.rows),
      junctions_(grid.columns.size() * grid.rows.size()) {
  const std::size_t n = grid.columns.size() - 1;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    whites_[i] = grid.cells[i] == TagPattern::white ? 1.0F : 0.0F;
    if (grid.cells[i] == TagPattern::white) cells_[i / n] |= 1U << (i % n);
    if (grid.cells[i] == TagPattern::unknown) unknown_[i / n] |= 1U << (i % n);
  }
  const auto cell = [&](int column, int row) {
    return static_cast<float>(cells_[static_cast<std::size_t>(row)] >> column & 1U);
  };
  for (int j = 1; j < num_rows_; ++j) {
    for (int i = 1; i < num_columns_; ++i)
      junctions_[static_cast<std::size_t>(j * num_columns_ + i)].contrast =
          cell(i, j) - cell(i - 1, j) - cell(i, j - 1) + cell(i - 1, j - 1);
  }
}

void TagModel::set(const TagParameters& parameters) {
  parameters_ = parameters;
  spread_ = std::exp(parameters[kLogSpread]);
  set_axis(columns_, kM1);
  set_axis(rows_, kM2);
  set_junctions();
}

void TagModel::set_axis(TagAxis& axis, int row_of_m) {
  for (TagLine& line : axis.lines) {
    const Vector2d across =
        parameters_.segment<2>(row_of_m) - line.at * parameters_.segment<2>(kM3);
    line.inv_length = 1 / across.norm();
    line.normal = across * line.inv_length;
    line.inv_spread = scale_ * line.inv_length / spread_;
    const double x2 = line.normal.x() * line.normal.x(), y2 = line.normal.y() * line.normal.y();
    line.box = kBoxCumulant * (x2 * x2 + y2 * y2) / (24 * std::pow(spread_, 4));
    line.single = {static_cast<float>(line.at), static_cast<float>(line.normal.x()),
                   static_cast<float>(line.normal.y()), static_cast<float>(line.inv_spread)};
    const double by_place = scale_ / spread_;
    line.single.by_x = static_cast<float>(by_place * line.normal.x());
    line.single.by_y = static_cast<float>(by_place * line.normal.y());
    const double constant = parameters_[row_of_m + 2] - line.at;
    line.single.by_1 = static_cast<float>(line.inv_spread * constant);
  }
}

// Beyond the product of its steps, the bivariate normal integral over a quadrant at (h, k) is the
// sum over n >= 0 of rho^(n+1) / (n+1)! He_n(h) He_n(k) times both densities (Pearson 1901).
void TagModel::set_junctions() {
  for (int j = 1; j < num_rows_; ++j) {
    for (int i = 1; i < num_columns_; ++i) {
      Junction& junction = junctions_[static_cast<std::size_t>(j * num_columns_ + i)];
      if (junction.contrast == 0) continue;
      const double rho = columns_.lines[static_cast<std::size_t>(i)].normal.dot(
          rows_.lines[static_cast<std::size_t>(j)].normal);
      double power = rho, factorial = 1;
      int n = 0;
      for (; n < kMaxTerms && std::abs(power) / (n + 1) > kLeastTerm; ++n) {
        factorial *= n + 1;
        junction.term[static_cast<std::size_t>(n)] =
            static_cast<float>(junction.contrast * power / factorial);
        power *= rho;
      }
      junction.num_terms = n;
    }
  }
}

TagPixel TagModel::evaluate(int c) const {
  Felt columns, rows;
  feel(columns_, c, columns);
  feel(rows_, c, rows);
  TagPixel pixel;
  pixel.white = blend(columns, rows);
  pixel.white += junctions(columns, rows);
  differentiate(columns_, c, columns, pixel);
  differentiate(rows_, c, rows, pixel);
  const auto per_unit = static_cast<float>(scale_ / spread_);
  pixel.by_x *= per_unit;
  pixel.by_y *= per_unit;
  return pixel;
}

void TagModel::feel(const TagAxis& axis, int c, Felt& felt) const {
  felt.first = axis.first(c);
  felt.count = axis.count(c);
  float before = 1;
  for (int i = 0; i < felt.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const TagAxis::Profile& profile = axis.profile(felt.first + i);
    felt.distance[k] = profile.distance[c];
    felt.density[k] = profile.density[c];
    felt.slope[k] = profile.slope[c];
    felt.by_distance[k] = 0;
    felt.weight[k] = before - profile.step[c];
    before = profile.step[c];
  }
  felt.weight[static_cast<std::size_t>(felt.count)] = before;
}

// White by the products of steps, as if rows and columns were at right angles; and by each step.
float TagModel::blend(Felt& columns, Felt& rows) const {
  float white = 0, last = 0;
  const float* cells =
      &whites_[static_cast<std::size_t>((rows.first - 1) * num_columns_ + columns.first - 1)];
  for (int j = 0; j <= rows.count; ++j, cells += num_columns_) {
    const auto k = static_cast<std::size_t>(j);
    const float weight = rows.weight[k];
    float sum = cells[0] * columns.weight[0];
    for (int i = 0; i < columns.count; ++i) {
      const auto n = static_cast<std::size_t>(i);
      sum += cells[i + 1] * columns.weight[n + 1];
      columns.by_distance[n] += weight * (cells[i + 1] - cells[i]);
    }
    white += weight * sum;
    if (j > 0) rows.by_distance[k - 1] = rows.slope[k - 1] * (sum - last);
    last = sum;
  }
  for (int i = 0; i < columns.count; ++i)
    columns.by_distance[static_cast<std::size_t>(i)] *= columns.slope[static_cast<std::size_t>(i)];
  return white;
}

// What quadrants have beyond the products of their steps.
float TagModel::junctions(Felt& columns, Felt& rows) const {
  float white = 0;
  for (int j = 0; j < rows.count; ++j) {
    for (int i = 0; i < columns.count; ++i) {
      const Junction& junction =
          junctions_[static_cast<std::size_t>((rows.first + j) * num_columns_ + columns.first + i)];
      if (junction.num_terms == 0) continue;
      const auto n = static_cast<std::size_t>(i), m = static_cast<std::size_t>(j);
      const float h = columns.distance[n], k = rows.distance[m];
      // Hermite's polynomials, two of each.
      float of_h = 1, next_of_h = h, of_k = 1, next_of_k = k;
      float sum = 0, by_h = 0, by_k = 0;
      for (int t = 0; t < junction.num_terms; ++t) {
        const float term = junction.term[static_cast<std::size_t>(t)];
        sum += term * of_h * of_k;
        by_h -= term * next_of_h * of_k;
        by_k -= term * of_h * next_of_k;
        const auto order = static_cast<float>(t + 1);
        of_h = std::exchange(next_of_h, h * next_of_h - order * of_h);
        of_k = std::exchange(next_of_k, k * next_of_k - order * of_k);
      }
      const float density = columns.density[n] * rows.density[m];
      white += density * sum;
      columns.by_distance[n] += density * by_h;
      rows.by_distance[m] += density * by_k;
    }
  }
  return white;
}

// The chain from the active lines to places and spread.
void TagModel::differentiate(const TagAxis& axis, int c, const Felt& felt, TagPixel& pixel) const {
  for (int i = 0; i < felt.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const TagLine::Single& line = axis.lines[static_cast<std::size_t>(felt.first + i)].single;
    const float by_place = felt.by_distance[k] * axis.profile(felt.first + i).factor[c];
    pixel.by_x += by_place * line.normal_x;
    pixel.by_y += by_place * line.normal_y;
    const float about = felt.by_distance[k] * felt.distance[k];
    pixel.about_xx += about * line.normal_x * line.normal_x;
    pixel.about_xy += about * line.normal_x * line.normal_y;
    pixel.about_yy += about * line.normal_y * line.normal_y;
  }
}

}  // namespace tagcal
