#include "tagcal/detect/refine_tag_axis.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/detect/refine_tag_kernels.hpp"

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

void TagAxis::reserve(std::size_t size) {
  first_.resize(size);
  count_.resize(size);
  values_.assign(5 * size * profiles_.size(), 1);  // the factor where nothing is stretched
  float* next = values_.data();
  for (Profile& profile : profiles_) {
    for (float** part :
         {&profile.distance, &profile.density, &profile.step, &profile.slope, &profile.factor}) {
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
  const int last = static_cast<int>(lines.size()) - 1;
  for (int i = 1; i < last; ++i) set_line(i, places, begin, end);
  // Lines that a start far off makes cross are not felt in their order.
  for (std::size_t c = static_cast<std::size_t>(begin); c < size; ++c)
    count_[c] = static_cast<std::uint8_t>(std::min<int>(count_[c], last - first_[c]));
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
  // Where that is no number, all may be.
  const bool is_known = std::isfinite(zero) && std::isfinite(half);
  const int from = is_known ? static_cast<int>(std::clamp<double>(zero - half, begin, end)) : begin;
  const int to = is_known ? static_cast<int>(std::clamp<double>(zero + half + 2, from, end)) : end;
  const auto past = static_cast<std::uint8_t>(line + 1);
  if (first > 0) std::fill(first_.begin() + begin, first_.begin() + from, past);
  if (last > 0) std::fill(first_.begin() + to, first_.begin() + end, past);
  const Profile& profile = profiles_[static_cast<std::size_t>(line)];
  fastest_tag_kernels().profile(
      {places.x, places.y, places.xx, places.xy, places.yy, single.normal_x, single.normal_y,
       single.by_x, single.by_y, single.by_1, static_cast<float>(known.box), from, to,
       profile.distance, profile.density, profile.step, profile.slope, profile.factor});
  for (int c = from; c < to; ++c) {
    const auto k = static_cast<std::size_t>(c);
    if (profile.distance[c] >= kReach) first_[k] = past;
    if (std::abs(profile.distance[c]) < kReach) ++count_[k];
  }
}

}  // namespace tagcal
