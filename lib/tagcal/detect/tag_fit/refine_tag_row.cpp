#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/detect/tag_fit/refine_tag_model.hpp"

// Selection of a row of pixels in the model.
namespace tagcal::internal {
using namespace tag_parameter;

// bend_basis() of a row, as polynomials in x.
void TagModel::bend_row(int begin, int end) {
  const Eigen::Matrix<float, kNumBends, 1> b = parameters_.segment<kNumBends>(kBend).cast<float>();
  if (row_.straight.x != nullptr) return bend_straight_row(b, begin, end);
  const auto left = static_cast<float>(row_.left), step = static_cast<float>(row_.step);
  const auto y = static_cast<float>(row_.y);
  const float yy = y * y;
  const std::array<float, 4> by_x = {yy * (b[0] + y * b[7]), y * (b[3] + y * b[6]), b[2] + y * b[5],
                                     b[4]};
  const std::array<float, 4> by_y = {yy * (y * b[11] - b[3]), y * (y * b[10] - b[2]),
                                     b[1] + y * b[9], b[8]};
  for (int c = begin; c < end; ++c) {
    const float x = left + static_cast<float>(c) * step;
    const auto k = static_cast<std::size_t>(c);
    bent_x_[k] = x + by_x[0] + x * (by_x[1] + x * (by_x[2] + x * by_x[3]));
    bent_y_[k] = y + by_y[0] + x * (by_y[1] + x * (by_y[2] + x * by_y[3]));
  }
}

// The same for straightened places, whose y varies along the row.
void TagModel::bend_straight_row(const Eigen::Matrix<float, kNumBends, 1>& b, int begin, int end) {
  const bool is_bent = (b.array() != 0).any();
  for (int c = begin; c < end; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const float x = bent_x_[k] = row_.straight.x[c];
    const float y = bent_y_[k] = row_.straight.y[c];
    if (!is_bent) continue;
    const float xx = x * x, xy = x * y, yy = y * y;
    bent_x_[k] += yy * b[0] + xx * b[2] + xy * b[3] + x * xx * b[4] + x * xy * b[5] +
                  x * yy * b[6] + y * yy * b[7];
    bent_y_[k] += xx * b[1] - xy * b[2] - yy * b[3] + x * xx * b[8] + x * xy * b[9] +
                  x * yy * b[10] + y * yy * b[11];
  }
}

void TagModel::set_row(const TagRow& row, double reach, int& begin, int& end) {
  if (begin >= end) return;
  row_ = row;
  const auto size = static_cast<std::size_t>(end + kTagPack);
  if (bent_x_.size() < size) {
    for (std::vector<float>* places : {&bent_x_, &bent_y_}) places->resize(2 * size);
    for (std::vector<std::int32_t>* values :
         {&columns_.first, &columns_.last, &rows_.first, &rows_.last, &is_known_})
      values->resize(2 * size);
  }
  bend_row(begin, end);
  std::fill(is_known_.begin() + begin, is_known_.begin() + end, -1);
  const double stretch = std::max(1.0, row.straight.stretch);
  for (const auto& [axis, felt] :
       {std::pair(&table_.columns, &columns_), std::pair(&table_.rows, &rows_)})
    fastest_tag_kernels().locate({axis, bent_x_.data(), bent_y_.data(), begin, end,
                                  static_cast<float>(kTagReach * stretch),
                                  static_cast<float>(reach * stretch), felt->first.data(),
                                  felt->last.data(), is_known_.data()});
  const auto is_known = [&](int c) { return is_known_[static_cast<std::size_t>(c)] != 0; };
  while (begin < end && !is_known(begin)) ++begin;
  while (begin < end && !is_known(end - 1)) --end;
}

TagModel::Seen TagModel::seen(int c) const {
  const auto k = static_cast<std::size_t>(c);
  // Lines that cross, after a poor start, are not reached in their order.
  const int num_columns = std::max(0, columns_.last[k] - columns_.first[k]);
  const int column = columns_.first[k] - 1;
  const std::uint32_t all = (2U << num_columns) - 1;
  std::uint32_t any_white = 0, all_white = all, unknown = is_known_[k] != 0 ? 0 : all;
  for (int j = rows_.first[k] - 1; j < std::max(rows_.first[k], rows_.last[k]); ++j) {
    const auto row = static_cast<std::size_t>(j);
    any_white |= cells_[row] >> column;
    all_white &= cells_[row] >> column;
    unknown |= unknown_[row] >> column;
  }
  if ((unknown & all) != 0) return Seen::unknown;
  if (all_white == all) return Seen::white;
  return (any_white & all) == 0 ? Seen::black : Seen::both;
}

}  // namespace tagcal::internal
