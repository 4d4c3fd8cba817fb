#include "tagcal/detect/refine_tag_axis.hpp"

#include <algorithm>
#include <cmath>

namespace tagcal {

TagAxis::TagAxis(const std::vector<double>& places) {
  for (const double at : places) lines.push_back({at});
  profiles_.resize(places.size());
}

AlongRow TagAxis::distance(int line, const AlongRow& numerator, const AlongRow& w) const {
  const TagLine& l = lines[static_cast<std::size_t>(line)];
  return combined(numerator, l.inv_spread, w, -l.inv_spread * l.at, 0);
}

void TagAxis::clip(const AlongRow& numerator, const AlongRow& w, double reach, int& begin,
                   int& end) const {
  const AlongRow low = distance(0, numerator, w);
  const AlongRow high = distance(static_cast<int>(lines.size()) - 1, numerator, w);
  const auto is_known = [&](int c) { return low(c) >= reach && high(c) <= -reach && w(c) > 0; };
  while (begin < end && !is_known(begin)) ++begin;
  while (begin < end && !is_known(end - 1)) --end;
}

void TagAxis::reserve(std::size_t size) {
  first_.resize(size);
  count_.resize(size);
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

void TagAxis::set_row(const AlongRow& numerator, const AlongRow& w, int begin, int end) {
  const auto size = static_cast<std::size_t>(end);
  if (first_.size() < size) reserve(2 * size);
  std::fill(first_.begin() + begin, first_.begin() + end, std::uint8_t{1});
  std::fill(count_.begin() + begin, count_.begin() + end, std::uint8_t{0});
  // The outermost lines have no far side.
  for (int i = 1; i + 1 < static_cast<int>(lines.size()); ++i)
    set_line(i, distance(i, numerator, w), begin, end);
}

// Lines come in ascending order, and so descending distance.
void TagAxis::set_line(int line, const AlongRow& distance, int begin, int end) {
  // A line through both ends, from which the distance differs by no more than `bend`.
  const double first = distance(begin), last = distance(end - 1);
  const double length = std::max(1, end - 1 - begin);
  const double bend = 0.125 * length * length *
                      std::max(std::abs(distance.second_derivative(begin)),
                               std::abs(distance.second_derivative(end - 1)));
  const double slope = last - first;
  const double per_distance = length / (std::abs(slope) < 1e-9 ? 1e-9 : slope);
  const double zero = begin - first * per_distance;
  const double half = (kReach + bend + 1e-3) * std::abs(per_distance);
  // [from, to) holds all where |distance| < kReach; to either side it keeps its sign.
  const int from = static_cast<int>(std::clamp<double>(zero - half, begin, end));
  const int to = static_cast<int>(std::clamp<double>(zero + half + 2, from, end));
  const auto past = static_cast<std::uint8_t>(line + 1);
  if (first > 0) std::fill(first_.begin() + begin, first_.begin() + from, past);
  if (last > 0) std::fill(first_.begin() + to, first_.begin() + end, past);
  Profile& profile = profiles_[static_cast<std::size_t>(line)];
  std::array<float, 4> power;
  for (std::size_t i = 0; i < 4; ++i) power[i] = static_cast<float>(distance.by_power[i]);
  const auto box = static_cast<float>(lines[static_cast<std::size_t>(line)].box);
  float* const z_out = profile.distance;
  float* const normal = profile.normal;
  float* const density = profile.density;
  float* const step = profile.step;
  float* const profile_slope = profile.slope;
  for (int c = from; c < to; ++c) {
    const auto x = static_cast<float>(c);
    const float z = power[0] + x * (power[1] + x * (power[2] + x * power[3]));
    const NormalValue value = normal_value(z);
    const float z2 = z * z;
    z_out[c] = z;
    normal[c] = value.integral;
    density[c] = value.density;
    step[c] = value.integral - box * z * (z2 - 3) * value.density;
    profile_slope[c] = value.density * (1 + box * (z2 * (z2 - 6) + 3));
  }
  for (int c = from; c < to; ++c) {
    const auto k = static_cast<std::size_t>(c);
    if (z_out[c] >= kReach) first_[k] = past;
    if (std::abs(z_out[c]) < kReach) ++count_[k];
  }
}

}  // namespace tagcal
