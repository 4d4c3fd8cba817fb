#include "tagcal/detect/tag_fit/tag_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using namespace tag_parameter;

constexpr double kBoxCumulant = -1.0 / 120;  // fourth, of the square of a pixel along a side
// Last term of a quadrant's series; the remainder is below a twentieth of it.
constexpr double kLeastTerm = 1e-3;  // numeric: truncation of a series
constexpr int kMaxTerms = 16;
// Spreads: the square of a shorter shift changes a level by less than 3e-4 of the contrast.
constexpr double kFirstOrder = 0.05;  // numeric: truncation of a series
// Largest black as a share of white.
constexpr double kMaxBlack = 0.9;  // numeric: keeps the model finite far from its minimum

// Kernels exist for some numbers of lines only; lines beyond those in reach have next to no weight.
int lines_taken(int num_felt) {
  for (const int most : {1, 2, 3, 4, 6, 8, 12, 16})
    if (num_felt <= most) return most;
  return kMaxTagLines;
}

// Cosine of the angle between two lines in the picture; `squares` is J J^T of RowPlaces.
double cosine(const TagLine& a, const TagLine& b, const Eigen::Matrix2d& squares) {
  const Vector2d m(a.by_x, a.by_y), n(b.by_x, b.by_y);
  return m.dot(squares * n) / std::sqrt(m.dot(squares * m) * n.dot(squares * n));
}

}  // namespace

TagModel::TagModel(const TagGrid& grid, double scale, double gamma)
    : scale_(scale), gamma_(gamma), column_lines_(grid.columns), row_lines_(grid.rows) {
  set_range(-HUGE_VALF, HUGE_VALF);
  const std::size_t n = grid.columns.size() - 1;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    if (grid.cells[i] == TagPattern::white) table_.cells[i / n] |= 1U << (i % n);
    if (grid.cells[i] == TagPattern::unknown) table_.unknown[i / n] |= 1U << (i % n);
  }
}

void TagModel::set_range(float least, float full, float beyond) {
  table_.least_level = least;
  table_.full_level = full;
  table_.beyond = beyond;
}

void TagModel::set_lines(const TagGrid& grid) {
  column_lines_ = grid.columns;
  row_lines_ = grid.rows;
  set(parameters_);
}

void TagModel::set(const TagParameters& parameters) {
  parameters_ = parameters;
  spread_ = std::exp(parameters[kLogSpread]);
  table_.per_unit = static_cast<float>(scale_ / spread_);
  table_.per_px = static_cast<float>(1 / spread_);
  table_.box = static_cast<float>(kBoxCumulant / (24 * std::pow(spread_, 4)));
  table_.black = static_cast<float>(parameters[kBlack]);
  table_.gain = static_cast<float>(parameters[kGain]);
  table_.gain_by_x = static_cast<float>(parameters[kGainSlope]);
  table_.gain_by_y = static_cast<float>(parameters[kGainSlope + 1]);
  const double black_grey =
      std::clamp(parameters[kBlack] / (parameters[kBlack] + parameters[kGain]), 0.0, kMaxBlack);
  table_.gamma = static_cast<float>(gamma_);
  table_.black_grey = static_cast<float>(black_grey);
  table_.black_light = static_cast<float>(std::pow(black_grey, 1 / gamma_));
  table_.shift = static_cast<float>(parameters[kShift] / spread_);
  table_.shift_on_tag = static_cast<float>(parameters[kShift + 1] / spread_);
  table_.is_far_shifted =
      std::abs(parameters[kShift]) + std::abs(parameters[kShift + 1]) > kFirstOrder * spread_;
  table_.last_x = static_cast<float>(parameters[kM3]);
  table_.last_y = static_cast<float>(parameters[kM3 + 1]);
  for (int k = 0; k < kNumBends; ++k) table_.bends[k] = static_cast<float>(parameters[kBend + k]);
  table_.is_bent = (parameters.segment<kNumBends>(kBend).array() != 0).any();
  set_axis(table_.columns, column_lines_, kM1);
  set_axis(table_.rows, row_lines_, kM2);
  set_num_terms(largest_cosine(Eigen::Matrix2d::Identity()));
}

void TagModel::set_axis(TagAxis& axis, const std::vector<double>& lines, int row_of_m) const {
  axis.count = static_cast<int>(lines.size());
  const double per_unit = scale_ / spread_;
  TagLine* line = axis.lines;
  for (const double at : lines) {
    const Vector2d across = parameters_.segment<2>(row_of_m) - at * parameters_.segment<2>(kM3);
    const double inv_length = 1 / across.norm();
    line->by_x = static_cast<float>(per_unit * inv_length * across.x());
    line->by_y = static_cast<float>(per_unit * inv_length * across.y());
    line->by_1 = static_cast<float>(per_unit * inv_length * (parameters_[row_of_m + 2] - at));
    line->at = static_cast<float>(at);
    line->inv_length = static_cast<float>(inv_length);
    ++line;
  }
  constexpr float kNever = -1e4F;
  std::fill(line, std::end(axis.lines), TagLine{table_.per_unit, 0, kNever, 0, 0, {}});
}

// The largest cosine between a column and a row, reached by outermost lines.
double TagModel::largest_cosine(const Eigen::Matrix2d& squares) const {
  double largest = 0;
  for (const int i : {0, table_.columns.count - 1})
    for (const int j : {0, table_.rows.count - 1})
      largest = std::max(largest,
                         std::abs(cosine(table_.columns.lines[i], table_.rows.lines[j], squares)));
  return largest;
}

void TagModel::set_num_terms(double largest) {
  int& n = table_.num_terms;
  double power = largest;
  for (n = 0; n < kMaxTerms && power / (n + 1) > kLeastTerm; ++n) power *= largest;
}

void TagModel::select(const TagRow& row, const float* levels, double reach, int begin, int end,
                      TagFlatSums* flat, bool has_light) {
  const auto size = static_cast<std::size_t>(std::max(0, end) + kTagPack);
  if (x_.size() < size) {
    for (std::vector<float>* places : {&x_, &y_}) places->resize(size);
    for (std::vector<std::int32_t>* values : {&columns_, &rows_, &num_felt_, &seen_})
      values->resize(size);
  }
  const RowPlaces& straight = row.straight;
  if (straight.x == nullptr) {
    for (int c = begin; c < end; ++c)
      x_[static_cast<std::size_t>(c)] = static_cast<float>(row.left + c * row.step);
    std::fill(y_.begin() + begin, y_.begin() + std::max(begin, end), static_cast<float>(row.y));
  }
  const double stretch = std::max(1.0, straight.stretch);
  row_ = {begin,
          end,
          straight.x == nullptr ? x_.data() : straight.x,
          straight.x == nullptr ? y_.data() : straight.y,
          levels,
          straight.xx,
          straight.xy,
          straight.yy,
          static_cast<float>(kTagReach * stretch),
          static_cast<float>(reach * stretch),
          has_light,
          columns_.data(),
          rows_.data(),
          num_felt_.data(),
          seen_.data()};
  fastest_tag_kernels().select(table_, row_, flat);
}

void TagModel::add(TagBlock& block, int c, int count, int in_patch) const {
  const auto copy = [&](const auto* from, auto* to) {
    for (int i = 0; i < count; i += kTagPack)
      std::memcpy(to + block.size + i, from + c + i, kTagPack * sizeof *from);
  };
  copy(row_.x, block.x);
  copy(row_.y, block.y);
  copy(row_.level, block.level);
  copy(row_.column, block.column);
  copy(row_.row, block.row);
  if (block.is_stretched) {
    copy(row_.xx, block.xx);
    copy(row_.xy, block.xy);
    copy(row_.yy, block.yy);
  }
  std::iota(block.in_patch + block.size, block.in_patch + block.size + count, in_patch);
  block.num_felt =
      std::max(block.num_felt, *std::max_element(row_.num_felt + c, row_.num_felt + c + count));
  block.size += count;
}

void TagModel::add_ends(const TagBlock& block, bool white, TagFlatSums& flat) const {
  fastest_tag_kernels().add_ends(table_, block, white, &flat);
}

void TagModel::evaluate(TagBlock& block, TagDerivatives& derivatives) {
  if (block.is_stretched) {
    double largest = 0;
    for (const int n : {0, block.size / 2, std::max(0, block.size - 1)}) {
      Eigen::Matrix2d squares;
      squares << block.xx[n], block.xy[n], block.xy[n], block.yy[n];
      largest = std::max(largest, largest_cosine(squares));
    }
    set_num_terms(largest);
  }
  block.num_felt = lines_taken(block.num_felt);
  fastest_tag_kernels().evaluate(table_, block, derivatives);
}

}  // namespace tagcal::internal
