#pragma once

#include <vector>

#include "tagcal/internal/degrees.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

// Private to io: values of scene.yaml, and values that change over the views.

namespace tagcal::internal {

// A day: stamps within it have microseconds in a double of seconds.
inline constexpr double kMostMilliseconds = 86'400'000;

inline double not_negative_or(const std::optional<YamlValue>& value, double otherwise) {
  return value ? value->not_negative() : otherwise;
}

inline double level_or(const std::optional<YamlValue>& value, double otherwise) {
  return value ? value->number_in(0, 1) : otherwise;
}

inline Eigen::Vector3d vector_or(const std::optional<YamlValue>& value,
                                 const Eigen::Vector3d& otherwise) {
  return value ? read_vector(*value) : otherwise;
}

// A value at times that are spread evenly over [0, 1], linear between them; or one for all times.
template <typename T>
class OverViews {
 public:
  explicit OverViews(std::vector<T> values) : values_(std::move(values)) {}

  const std::vector<T>& values() const { return values_; }
  bool moves() const { return values_.size() > 1; }

  T at(double t) const {
    const double place = t * static_cast<double>(values_.size() - 1);
    const auto i = static_cast<std::size_t>(place);
    if (i + 1 >= values_.size()) return values_.back();
    const double share = place - static_cast<double>(i);
    return (1 - share) * values_[i] + share * values_[i + 1];
  }

 private:
  std::vector<T> values_;  // not empty
};

using NumberOverViews = OverViews<double>;
using VectorOverViews = OverViews<Eigen::Vector3d>;

// A number, or a list of at most 1000 numbers.
NumberOverViews numbers_over_views(const YamlValue& value);
NumberOverViews degrees_over_views(
    const std::optional<YamlValue>& value);  // in radians; 0 if missing

// [x, y, z], or a list of at most 1000 of them.
VectorOverViews vectors_over_views(const YamlValue& value);

}  // namespace tagcal::internal
