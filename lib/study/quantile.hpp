#pragma once

#include <Eigen/LU>
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

// The squared Mahalanobis distance of an error by its claimed covariance; infinite if this is not
// positive, because nothing is within such a claim.
inline double squared_distance(const Eigen::Vector2d& error, const Eigen::Matrix2d& covariance) {
  const double square = error.dot(covariance.inverse() * error);
  return square >= 0 ? square : std::numeric_limits<double>::infinity();
}

}  // namespace tagcal::study
