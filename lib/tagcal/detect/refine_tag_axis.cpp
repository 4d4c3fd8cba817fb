#include "tagcal/detect/refine_tag_axis.hpp"

#include <algorithm>
#include <cmath>

namespace tagcal {

TagAxis::TagAxis(const std::vector<double>& places) {
  for (const double at : places) lines.push_back({at});
  profiles_.resize(places.size());
}

void TagAxis::clip(const RowPlaces& places, double reach, int& begin, int& end) const {
  const TagLine::Single& low = lines.front().single;
  const TagLine::Single& high = lines.back().single;
  reach *= std::max(1.0, places.stretch);
  const auto is_known = [&](int c) {
    const float x = places.x[c], y = places.y[c];
    return low.distance(x, y) >= reach && high.distance(x, y) <= -reach;
  };
  while (begin < end && !is_known(begin)) ++begin;
  while (begin < end && !is_known(end - 1)) --end;
}

void TagAxis::set_factors(const TagLine& line, const RowPlaces& places, int from, int to) {
  const float x = line.single.normal_x, y = line.single.normal_y;
  if (places.xx == nullptr) {
    std::fill(factor_.begin() + from, factor_.begin() + to, 1.0F);
    return;
  }
  for (int c = from; c < to; ++c)
    factor_[static_cast<std::size_t>(c)] =
        1 / std::sqrt(x * x * places.xx[c] + 2 * x * y * places.xy[c] + y * y * places.yy[c]);
}

void TagAxis::reserve(std::size_t size) {
  first_.resize(size);
  count_.resize(size);
  factor_.resize(size);
  values_.resize(5 * size * profiles_.size());
  float* next = values_.data();
  for (Profile& profile : profiles_) {
    for (float** part :
         {&profile.distance, &profile.normal, &profile.density, &profile.step, &profile.slope}) {
      *part = next;
      next += size;
    }
  }
}

void TagAxis::set_row(const RowPlaces& places, int begin, int end) {
  const auto size = static_cast<std::size_t>(end);
  if (first_.size() < size) reserve(2 * size);
  std::fill(first_.begin() + begin, first_.begin() + end, std::uint8_t{1});
  std::fill(count_.begin() + begin, count_.begin() + end, std::uint8_t{0});
  // The outermost lines have no far side.
  for (int i = 1; i + 1 < static_cast<int>(lines.size()); ++i) set_line(i, places, begin, end);
}

// Lines come in ascending order, and so descending distance.
void TagAxis::set_line(int line, const RowPlaces& places, int begin, int end) {
  const TagLine& known = lines[static_cast<std::size_t>(line)];
  const TagLine::Single& single = known.single;
  // A line through both ends, from which the distance differs by no more than `bend`.
  const double first = single.distance(places.x[begin], places.y[begin]);
  const double last = single.distance(places.x[end - 1], places.y[end - 1]);
  const double length = std::max(1, end - 1 - begin);
  const double bend = std::hypot(single.by_x, single.by_y) * places.bulge;
  const double slope = last - first;
  const double per_distance = length / (std::abs(slope) < 1e-9 ? 1e-9 : slope);
  const double zero = begin - first * per_distance;
  const double half = (kReach * places.stretch + bend + 1e-3) * std::abs(per_distance);
  // [from, to) holds all where |distance| < kReach; to either side it keeps its sign.
  const int from = static_cast<int>(std::clamp<double>(zero - half, begin, end));
  const int to = static_cast<int>(std::clamp<double>(zero + half + 2, from, end));
  const auto past = static_cast<std::uint8_t>(line + 1);
  if (first > 0) std::fill(first_.begin() + begin, first_.begin() + from, past);
  if (last > 0) std::fill(first_.begin() + to, first_.begin() + end, past);
  const Profile& profile = profiles_[static_cast<std::size_t>(line)];
  const auto box = static_cast<float>(known.box);
  set_factors(known, places, from, to);
  const float* const factor = factor_.data();
  for (int c = from; c < to; ++c) {
    const float f = factor[c];
    const float z = f * (single.by_x * places.x[c] + single.by_y * places.y[c] + single.by_1);
    const NormalValue value = normal_value(z);
    const float z2 = z * z;
    profile.distance[c] = z;
    profile.normal[c] = value.integral;
    profile.density[c] = f * value.density;
    profile.step[c] = value.integral - box * z * (z2 - 3) * value.density;
    profile.slope[c] = f * value.density * (1 + box * (z2 * (z2 - 6) + 3));
  }
  for (int c = from; c < to; ++c) {
    const auto k = static_cast<std::size_t>(c);
    if (profile.distance[c] >= kReach) first_[k] = past;
    if (std::abs(profile.distance[c]) < kReach) ++count_[k];
  }
}

}  // namespace tagcal
