#include "tagcal/detect/refine_tag_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using namespace tag_parameter;

constexpr double kBoxCumulant = -1.0 / 120;  // fourth, of the square of a pixel along a side
constexpr float kLeastCorrelation = 1e-3F;   // below it, quadrants are products of steps
constexpr float kInvTwoPi = 0.159154943F;

}  // namespace

TagModel::TagModel(const TagGrid& grid, double scale)
    : scale_(scale),
      num_columns_(static_cast<int>(grid.columns.size()) - 1),
      num_rows_(static_cast<int>(grid.rows.size()) - 1),
      cells_(grid.rows.size() - 1, 0),
      unknown_(grid.rows.size() - 1, 0),
      columns_(grid.columns),
      rows_(grid.rows),
      junctions_(grid.columns.size() * grid.rows.size()) {
  const std::size_t n = grid.columns.size() - 1;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
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

void TagModel::set_junctions() {
  // Gauss-Legendre on [0, 1].
  constexpr std::array<double, kNodes> places = {0.0694318442029737, 0.3300094782075719,
                                                 0.6699905217924281, 0.9305681557970263};
  constexpr std::array<double, kNodes> weights = {0.1739274225687269, 0.3260725774312731,
                                                  0.3260725774312731, 0.1739274225687269};
  for (int j = 1; j < num_rows_; ++j) {
    for (int i = 1; i < num_columns_; ++i) {
      Junction& junction = junctions_[static_cast<std::size_t>(j * num_columns_ + i)];
      if (junction.contrast == 0) continue;
      const TagLine& column = columns_.lines[static_cast<std::size_t>(i)];
      const TagLine& row = rows_.lines[static_cast<std::size_t>(j)];
      const double rho = column.normal.dot(row.normal);
      const double angle = std::asin(rho);
      junction.correlation = static_cast<float>(rho);
      junction.inv_root = static_cast<float>(1 / std::sqrt(1 - rho * rho));
      junction.turn_column = (column.inv_length * (row.normal - rho * column.normal)).cast<float>();
      junction.turn_row = (row.inv_length * (column.normal - rho * row.normal)).cast<float>();
      for (std::size_t k = 0; k < kNodes; ++k) {
        const double sine = std::sin(places[k] * angle);
        junction.node[k] = static_cast<float>(2 * sine);
        junction.decay[k] = static_cast<float>(0.5 / (1 - sine * sine));
        junction.weight[k] = static_cast<float>(weights[k] * angle / (2 * std::numbers::pi));
      }
    }
  }
}

void TagModel::evaluate(int c, TagPixel& pixel) {
  blend(c, pixel);
  add_junctions(c, pixel);
  differentiate(c, pixel);
}

// The products of steps, as if rows and columns were at right angles.
void TagModel::blend(int c, TagPixel& pixel) {
  const int column = columns_.first(c), num_columns = columns_.count(c);
  const int row = rows_.first(c), num_rows = rows_.count(c);
  std::array<float, kMaxTagLines> weight;      // of the active columns of cells
  std::array<float, kMaxTagLines> difference;  // over the active lines
  float before = 1;
  for (int i = 0; i < num_columns; ++i) {
    const float step = columns_.profile(column + i).step[static_cast<std::size_t>(c)];
    weight[static_cast<std::size_t>(i)] = before - step;
    difference[static_cast<std::size_t>(i)] = 0;
    before = step;
  }
  weight[static_cast<std::size_t>(num_columns)] = before;
  float white = 0, last = 0, weight_before = 1;
  for (int j = 0; j <= num_rows; ++j) {
    const auto k = static_cast<std::size_t>(j);
    const bool ends = j == num_rows;
    const float step = ends ? 0 : rows_.profile(row + j).step[static_cast<std::size_t>(c)];
    const float row_weight = weight_before - step;
    weight_before = step;
    const std::uint32_t bits = cells_[static_cast<std::size_t>(row - 1 + j)] >> (column - 1);
    float sum = (bits & 1U) != 0 ? weight[0] : 0;
    for (int i = 0; i < num_columns; ++i) {
      const int here = static_cast<int>(bits >> i & 3U);  // left cell, right cell
      const auto n = static_cast<std::size_t>(i);
      if ((here & 2) != 0) sum += weight[n + 1];
      if (here == 1) difference[n] -= row_weight;
      if (here == 2) difference[n] += row_weight;
    }
    white += row_weight * sum;
    if (j > 0) by_rows_.distance[k - 1] *= sum - last;
    if (!ends) {
      by_rows_.distance[k] = rows_.profile(row + j).slope[static_cast<std::size_t>(c)];
      by_rows_.turn[k].setZero();
    }
    last = sum;
  }
  for (int i = 0; i < num_columns; ++i) {
    const auto n = static_cast<std::size_t>(i);
    by_columns_.distance[n] =
        difference[n] * columns_.profile(column + i).slope[static_cast<std::size_t>(c)];
    by_columns_.turn[n].setZero();
  }
  pixel.white = white;
}

void TagModel::add_junctions(int c, TagPixel& pixel) {
  for (int j = 0; j < rows_.count(c); ++j) {
    for (int i = 0; i < columns_.count(c); ++i) {
      const Junction& junction = junctions_[static_cast<std::size_t>(
          (rows_.first(c) + j) * num_columns_ + columns_.first(c) + i)];
      if (junction.contrast == 0 || std::abs(junction.correlation) < kLeastCorrelation) continue;
      add_junction(junction, c, i, j, pixel);
    }
  }
}

// What the bivariate normal integral over a quadrant has beyond the product of its steps.
void TagModel::add_junction(const Junction& junction, int c, int column, int row, TagPixel& pixel) {
  const auto at = static_cast<std::size_t>(c);
  const auto i = static_cast<std::size_t>(column), j = static_cast<std::size_t>(row);
  const TagAxis::Profile& across = columns_.profile(columns_.first(c) + column);
  const TagAxis::Profile& down = rows_.profile(rows_.first(c) + row);
  const float h = across.distance[at], k = down.distance[at];
  const float rho = junction.correlation, inv_root = junction.inv_root;
  const float squares = h * h + k * k, product = h * k;
  const float exponent = 0.5F * (squares - 2 * rho * product) * inv_root * inv_root;
  if (exponent > 8) return;  // below 5e-5 of the contrast
  float sum = 0;
  for (std::size_t n = 0; n < kNodes; ++n)
    sum +=
        junction.weight[n] * exp_minus(junction.decay[n] * (squares - junction.node[n] * product));
  const float contrast = junction.contrast;
  pixel.white += contrast * sum;
  by_columns_.distance[i] += contrast * across.density[at] *
                             (normal_value((k - rho * h) * inv_root).integral - down.normal[at]);
  by_rows_.distance[j] += contrast * down.density[at] *
                          (normal_value((h - rho * k) * inv_root).integral - across.normal[at]);
  const float by_rho = contrast * inv_root * kInvTwoPi * exp_minus(exponent);
  by_columns_.turn[i] += by_rho * junction.turn_column;
  by_rows_.turn[j] += by_rho * junction.turn_row;
}

// The chain from the active lines to the parameters.
void TagModel::differentiate(int c, TagPixel& pixel) const {
  const auto x = static_cast<float>(row_.left + c * row_.step), y = static_cast<float>(row_.y);
  const auto gain = static_cast<float>(parameters_[kGain] + parameters_[kGainSlope] * x +
                                       parameters_[kGainSlope + 1] * y);
  const float place_x = bent_x_[static_cast<std::size_t>(c)],
              place_y = bent_y_[static_cast<std::size_t>(c)];
  const auto unit = static_cast<float>(spread_ / scale_);
  float by_log_spread = 0, by_x = 0, by_y = 0, by_m3_x = 0, by_m3_y = 0;
  std::array<float, kCount>& out = pixel.by_parameter;
  const auto collect = [&](const TagAxis& axis, const ByLines& by, int m) {
    float m_x = 0, m_y = 0, m_1 = 0;
    const int first = axis.first(c);
    for (int i = 0; i < axis.count(c); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (by.distance[k] == 0) continue;  // the same colour on both sides
      const TagLine::Single& line = axis.lines[static_cast<std::size_t>(first + i)].single;
      const float h = axis.profile(first + i).distance[static_cast<std::size_t>(c)];
      const float n_x = line.normal_x, n_y = line.normal_y;
      const float along = by.distance[k] * line.inv_spread;
      const float normal_x = along * (place_x - h * unit * n_x) + by.turn[k].x();
      const float normal_y = along * (place_y - h * unit * n_y) + by.turn[k].y();
      m_x += normal_x;
      m_y += normal_y;
      m_1 += along;
      by_m3_x -= line.at * normal_x;
      by_m3_y -= line.at * normal_y;
      by_log_spread -= by.distance[k] * h;
      by_x += by.distance[k] * n_x;
      by_y += by.distance[k] * n_y;
    }
    out[static_cast<std::size_t>(m)] = gain * m_x;
    out[static_cast<std::size_t>(m + 1)] = gain * m_y;
    out[static_cast<std::size_t>(m + 2)] = gain * m_1;
  };
  collect(columns_, by_columns_, kM1);
  collect(rows_, by_rows_, kM2);
  out[kM3] = gain * by_m3_x;
  out[kM3 + 1] = gain * by_m3_y;
  out[kLogSpread] = gain * by_log_spread;
  out[kBlack] = 1;
  out[kGain] = pixel.white;
  out[kGainSlope] = pixel.white * x;
  out[kGainSlope + 1] = pixel.white * y;
  by_x *= gain / unit;
  by_y *= gain / unit;
  const float xx = x * x, xy = x * y, yy = y * y;
  float* const bend = &out[kBend];
  bend[0] = by_x * yy;
  bend[1] = by_y * xx;
  bend[2] = by_x * xx - by_y * xy;
  bend[3] = by_x * xy - by_y * yy;
  const std::array<float, 4> cubes = {x * xx, x * xy, x * yy, y * yy};
  for (std::size_t i = 0; i < 4; ++i) {
    bend[4 + i] = by_x * cubes[i];
    bend[8 + i] = by_y * cubes[i];
  }
}

}  // namespace tagcal
