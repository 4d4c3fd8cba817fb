#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace tagcal::study {

// The quantile of the values at this share, by the nearest rank; NaN if there are no values.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace tagcal::study
