#include "tagcal/detect/refine_tag_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace tag_parameter;

constexpr double kReach = 4;         // spreads at which an edge is felt
constexpr double kUnknownReach = 3;  // and beyond which the unknown is not: less than 0.14 % of it
constexpr double kInvSqrt2Pi = 0.5 * std::numbers::inv_sqrtpi * std::numbers::sqrt2;
constexpr double kBoxCumulant = -1.0 / 120;  // fourth, of the square of a pixel along a side
constexpr double kLeastCorrelation = 1e-3;   // below it, quadrants are products of steps

// Normal integral and density, to 1e-9 in [-kReach, kReach], by Taylor steps from a table.
class NormalTable {
 public:
  NormalTable() {
    for (int i = 0; i < kSize; ++i) {
      const double z = (i - kSize / 2) * kStep;
      entries_[static_cast<std::size_t>(i)] = {0.5 * std::erfc(-z / std::numbers::sqrt2),
                                               kInvSqrt2Pi * std::exp(-0.5 * z * z)};
    }
  }

  struct Entry {
    double integral;
    double density;
  };
  Entry at(double z) const {
    const int i = static_cast<int>(z * (1 / kStep) + kSize / 2 + 0.5);
    if (i < 0 || i >= kSize) return {z < 0 ? 0.0 : 1.0, 0.0};
    const double a = (i - kSize / 2) * kStep;
    const double d = z - a;
    const Entry& e = entries_[static_cast<std::size_t>(i)];
    const double b = a * a - 1;
    return {e.integral + e.density * d * (1 - d * (a / 2 - d * b / 6)),
            e.density * (1 - d * (a - d * (b / 2 - d * a * (b - 2) / 6)))};
  }

 private:
  static constexpr double kStep = 1.0 / 32;
  static constexpr int kSize = 2 * 5 * 32 + 1;
  std::array<Entry, kSize> entries_{};
};

const NormalTable& normal_table() {
  static const NormalTable table;
  return table;
}

}  // namespace

bool TagAxis::approach(double numerator, double w) {
  const int n = static_cast<int>(lines.size()) - 1;
  const auto distance = [&](int i) {
    const Line& line = lines[static_cast<std::size_t>(i)];
    return line.inv_spread * (numerator - line.at * w);
  };
  if (!(distance(0) >= kUnknownReach) || !(distance(n) <= -kUnknownReach)) return false;
  while (cell + 1 < n && distance(cell + 1) >= 0) ++cell;
  while (cell > 0 && distance(cell) < 0) --cell;
  first = cell + 1;
  while (first > 1 && distance(first - 1) < kReach) --first;
  count = 0;
  for (int i = first; i < n; ++i) {  // the first and the last line have no far side
    const double z = distance(i);
    if (z <= -kReach) break;
    h[static_cast<std::size_t>(count++)] = z;
  }
  return true;
}

// Profiles of the active lines' steps, and so the weights of the cells between them.
void TagAxis::weigh() {
  const NormalTable& table = normal_table();
  double before = 1;
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double z = h[k];
    const double box = lines[static_cast<std::size_t>(first + i)].box;
    const NormalTable::Entry entry = table.at(z);
    const double z2 = z * z;
    normal[k] = entry.integral;
    density[k] = entry.density;
    slope[k] = entry.density * (1 + box * (z2 * (z2 - 6) + 3));
    const double step = entry.integral - box * z * (z2 - 3) * entry.density;
    weight[k] = before - step;
    before = step;
  }
  weight[static_cast<std::size_t>(count)] = before;
}

TagModel::TagModel(const TagPattern& pattern, double scale)
    : scale_(scale),
      num_cells_(static_cast<int>(pattern.lines.size()) - 1),
      cells_(pattern.white.begin(), pattern.white.end()) {
  for (TagAxis* axis : {&columns_, &rows_}) {
    for (const double at : pattern.lines) axis->lines.push_back({at});
  }
  junctions_.resize(pattern.lines.size() * pattern.lines.size());
}

void TagModel::set(const TagParameters& parameters) {
  parameters_ = parameters;
  spread_ = std::exp(parameters[kLogSpread]);
  set_axis(columns_, kM1);
  set_axis(rows_, kM2);
  set_junctions();
}

void TagModel::set_axis(TagAxis& axis, int row_of_m) {
  for (TagAxis::Line& line : axis.lines) {
    const Vector2d across =
        parameters_.segment<2>(row_of_m) - line.at * parameters_.segment<2>(kM3);
    line.inv_length = 1 / across.norm();
    line.normal = across * line.inv_length;
    line.inv_spread = scale_ * line.inv_length / spread_;
    const Eigen::Array2d square = line.normal.array().square();
    line.box = kBoxCumulant * square.square().sum() / (24 * std::pow(spread_, 4));
  }
}

void TagModel::set_junctions() {
  // Gauss-Legendre on [0, 1].
  constexpr std::array<double, kNodes> places = {0.0694318442029737, 0.3300094782075719,
                                                 0.6699905217924281, 0.9305681557970263};
  constexpr std::array<double, kNodes> weights = {0.1739274225687269, 0.3260725774312731,
                                                  0.3260725774312731, 0.1739274225687269};
  for (int j = 1; j < num_cells_; ++j) {
    for (int i = 1; i < num_cells_; ++i) {
      Junction& junction = junctions_[static_cast<std::size_t>(j * (num_cells_ + 1) + i)];
      junction.contrast = cell(i, j) - cell(i - 1, j) - cell(i, j - 1) + cell(i - 1, j - 1);
      if (junction.contrast == 0) continue;
      const double rho = columns_.lines[static_cast<std::size_t>(i)].normal.dot(
          rows_.lines[static_cast<std::size_t>(j)].normal);
      junction.correlation = rho;
      junction.inv_root = 1 / std::sqrt(1 - rho * rho);
      const double angle = std::asin(rho);
      for (std::size_t k = 0; k < kNodes; ++k) {
        const double sine = std::sin(places[k] * angle);
        junction.node[k] = 2 * sine;
        junction.decay[k] = -0.5 / (1 - sine * sine);
        junction.weight[k] = weights[k] * angle / (2 * std::numbers::pi);
      }
    }
  }
}

TagModel::Pixel TagModel::evaluate(double x, double y, TagPixel& pixel) {
  place_ = Vector2d(x, y);
  place_ += bend_basis(x, y) * parameters_.segment<4>(kBend);
  const Vector3d p(place_.x(), place_.y(), 1);
  const double w = p.head<2>().dot(parameters_.segment<2>(kM3)) + 1;
  if (!(w > 0)) return Pixel::unknown;
  if (!columns_.approach(p.dot(parameters_.segment<3>(kM1)), w)) return Pixel::unknown;
  if (!rows_.approach(p.dot(parameters_.segment<3>(kM2)), w)) return Pixel::unknown;
  if (is_flat()) {
    pixel.white = cell(columns_.first - 1, rows_.first - 1);
    return Pixel::flat;
  }
  columns_.weigh();
  rows_.weigh();
  blend(pixel);
  add_junctions(pixel);
  differentiate(x, y, pixel);
  return Pixel::graded;
}

bool TagModel::is_flat() const {
  const double white = cell(columns_.first - 1, rows_.first - 1);
  for (int j = 0; j <= rows_.count; ++j) {
    for (int i = 0; i <= columns_.count; ++i) {
      if (cell(columns_.first - 1 + i, rows_.first - 1 + j) != white) return false;
    }
  }
  return true;
}

// The products of steps, as if rows and columns were at right angles.
void TagModel::blend(TagPixel& pixel) {
  std::array<double, kMaxTagLines + 1> column_white{};
  std::array<double, kMaxTagLines + 1> row_white{};
  for (int j = 0; j <= rows_.count; ++j) {
    const double weight = rows_.weight[static_cast<std::size_t>(j)];
    double sum = 0;
    for (int i = 0; i <= columns_.count; ++i) {
      const double white = cell(columns_.first - 1 + i, rows_.first - 1 + j);
      sum += white * columns_.weight[static_cast<std::size_t>(i)];
      column_white[static_cast<std::size_t>(i)] += white * weight;
    }
    row_white[static_cast<std::size_t>(j)] = sum;
  }
  pixel.white = 0;
  for (int j = 0; j <= rows_.count; ++j) {
    const auto k = static_cast<std::size_t>(j);
    pixel.white += row_white[k] * rows_.weight[k];
    if (j == rows_.count) break;
    by_row_[k] = rows_.slope[k] * (row_white[k + 1] - row_white[k]);
    turn_row_[k].setZero();
  }
  for (int i = 0; i < columns_.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    by_column_[k] = columns_.slope[k] * (column_white[k + 1] - column_white[k]);
    turn_column_[k].setZero();
  }
}

// What the bivariate normal integral over a quadrant has beyond the product of its steps.
void TagModel::add_junctions(TagPixel& pixel) {
  const NormalTable& table = normal_table();
  for (int j = 0; j < rows_.count; ++j) {
    for (int i = 0; i < columns_.count; ++i) {
      const Junction& junction = junctions_[static_cast<std::size_t>(
          (rows_.first + j) * (num_cells_ + 1) + columns_.first + i)];
      const double rho = junction.correlation;
      if (junction.contrast == 0 || std::abs(rho) < kLeastCorrelation) continue;
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double h = columns_.h[a], k = rows_.h[b];
      const double squares = h * h + k * k, product = h * k;
      // Beyond this the correction is below 1e-5 for any correlation met here.
      if (squares - std::abs(2 * rho * product) > 20 * (1 - rho * rho)) continue;
      double sum = 0;
      for (std::size_t n = 0; n < kNodes; ++n)
        sum += junction.weight[n] *
               std::exp(junction.decay[n] * (squares - junction.node[n] * product));
      pixel.white += junction.contrast * sum;
      const double inv_root = junction.inv_root;
      by_column_[a] += junction.contrast * columns_.density[a] *
                       (table.at((k - rho * h) * inv_root).integral - rows_.normal[b]);
      by_row_[b] += junction.contrast * rows_.density[b] *
                    (table.at((h - rho * k) * inv_root).integral - columns_.normal[a]);
      const double by_rho =
          junction.contrast * inv_root / (2 * std::numbers::pi) *
          std::exp(-0.5 * (squares - 2 * rho * product) * inv_root * inv_root);
      const TagAxis::Line& column = columns_.lines[static_cast<std::size_t>(columns_.first + i)];
      const TagAxis::Line& row = rows_.lines[static_cast<std::size_t>(rows_.first + j)];
      turn_column_[a] += by_rho * column.inv_length * (row.normal - rho * column.normal);
      turn_row_[b] += by_rho * row.inv_length * (column.normal - rho * row.normal);
    }
  }
}

// The chain from the active lines to the parameters.
void TagModel::differentiate(double x, double y, TagPixel& pixel) const {
  const double gain = parameters_[kGain] + parameters_[kGainSlope] * x +
                      parameters_[kGainSlope + 1] * y;
  double by_log_spread = 0;
  Vector2d by_place = Vector2d::Zero();
  Vector2d by_m3 = Vector2d::Zero();
  const auto collect = [&](const TagAxis& axis, const auto& by_line, const auto& turn, int row) {
    Vector3d by_m = Vector3d::Zero();
    for (int i = 0; i < axis.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const TagAxis::Line& line = axis.lines[static_cast<std::size_t>(axis.first + i)];
      const double along = by_line[k] * line.inv_spread;
      const Vector2d foot = place_ - axis.h[k] * spread_ / scale_ * line.normal;
      const Vector2d by_normal = along * foot + turn[k];
      by_m += Vector3d(by_normal.x(), by_normal.y(), along);
      by_m3 -= line.at * by_normal;
      by_log_spread -= by_line[k] * axis.h[k];
      by_place += by_line[k] * line.normal;
    }
    for (int i = 0; i < 3; ++i)
      pixel.by_parameter[static_cast<std::size_t>(row + i)] = static_cast<float>(gain * by_m[i]);
  };
  collect(columns_, by_column_, turn_column_, kM1);
  collect(rows_, by_row_, turn_row_, kM2);
  const auto put = [&](int i, double value) {
    pixel.by_parameter[static_cast<std::size_t>(i)] = static_cast<float>(value);
  };
  put(kM3, gain * by_m3.x());
  put(kM3 + 1, gain * by_m3.y());
  put(kLogSpread, gain * by_log_spread);
  put(kBlack, 1);
  put(kGain, pixel.white);
  put(kGainSlope, pixel.white * x);
  put(kGainSlope + 1, pixel.white * y);
  const Eigen::Vector4d by_bend =
      (gain * scale_ / spread_) * bend_basis(x, y).transpose() * by_place;
  for (int i = 0; i < 4; ++i) put(kBend + i, by_bend[i]);
}

}  // namespace tagcal
