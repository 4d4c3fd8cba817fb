#include <algorithm>
#include <cmath>

#include "tagcal/detect/refine_tag_model.hpp"

// The model's turn to a row of pixels.
namespace tagcal {
namespace {

using namespace tag_parameter;

// The largest distance of the row's places from even steps between its ends.
double bulge(const std::vector<float>& place, int begin, int end) {
  const auto first = static_cast<std::size_t>(begin), last = static_cast<std::size_t>(end - 1);
  const float step =
      (place[last] - place[first]) / static_cast<float>(std::max(1, end - 1 - begin));
  float result = 0;
  for (int c = begin; c < end; ++c) {
    const float even = place[first] + static_cast<float>(c - begin) * step;
    result = std::max(result, std::abs(place[static_cast<std::size_t>(c)] - even));
  }
  return static_cast<double>(result);
}

}  // namespace

// As bend_basis() has it.
void TagModel::bend_row(int begin, int end) {
  if (bent_x_.size() < static_cast<std::size_t>(end)) {
    bent_x_.resize(static_cast<std::size_t>(end));
    bent_y_.resize(static_cast<std::size_t>(end));
  }
  const Eigen::Matrix<float, kNumBends, 1> b = parameters_.segment<kNumBends>(kBend).cast<float>();
  const auto left = static_cast<float>(row_.left), step = static_cast<float>(row_.step);
  const auto y = static_cast<float>(row_.y);
  const float yy = y * y;
  const std::array<float, 4> by_x = {yy * (b[0] + y * b[7]), y * (b[3] + y * b[6]), b[2] + y * b[5],
                                     b[4]};
  const std::array<float, 4> by_y = {yy * (y * b[11] - b[3]), y * (y * b[10] - b[2]),
                                     b[1] + y * b[9], b[8]};
  const bool is_known = row_.straight.x != nullptr;
  for (int c = begin; c < end; ++c) {
    const float x = left + static_cast<float>(c) * step;
    const auto k = static_cast<std::size_t>(c);
    bent_x_[k] =
        (is_known ? row_.straight.x[c] : x) + by_x[0] + x * (by_x[1] + x * (by_x[2] + x * by_x[3]));
    bent_y_[k] =
        (is_known ? row_.straight.y[c] : y) + by_y[0] + x * (by_y[1] + x * (by_y[2] + x * by_y[3]));
  }
}

RowPlaces TagModel::places() const {
  RowPlaces places = row_.straight;
  places.x = bent_x_.data();
  places.y = bent_y_.data();
  places.bulge = bulge_;
  return places;
}

void TagModel::set_row(const TagRow& row, double reach, int& begin, int& end) {
  if (begin >= end) return;
  row_ = row;
  bend_row(begin, end);
  columns_.clip(places(), reach, begin, end);
  rows_.clip(places(), reach, begin, end);
  if (begin >= end) return;
  bulge_ = (bulge(bent_x_, begin, end) + bulge(bent_y_, begin, end));
  columns_.set_row(places(), begin, end);
  rows_.set_row(places(), begin, end);
}

TagModel::Seen TagModel::seen(int c) const {
  const int column = columns_.first(c) - 1;
  const std::uint32_t all = (2U << columns_.count(c)) - 1;
  const auto row = static_cast<std::size_t>(rows_.first(c) - 1);
  const auto num_rows = static_cast<std::size_t>(rows_.count(c)) + 1;
  std::uint32_t any_white = 0, all_white = all, unknown = 0;
  for (std::size_t j = row; j < row + num_rows; ++j) {
    any_white |= cells_[j] >> column;
    all_white &= cells_[j] >> column;
    unknown |= unknown_[j] >> column;
  }
  if ((unknown & all) != 0) return Seen::unknown;
  if (all_white == all) return Seen::white;
  return (any_white & all) == 0 ? Seen::black : Seen::both;
}

}  // namespace tagcal
