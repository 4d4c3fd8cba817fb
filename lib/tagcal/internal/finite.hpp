#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "tagcal/error.hpp"

namespace tagcal::internal {

// Throws Error if a number of the input is infinite or NaN.
inline void require_finite(double value, const char* what) {
  if (!std::isfinite(value)) throw Error(std::string(what) + ": must be finite");
}

template <typename Derived>
void require_finite(const Eigen::DenseBase<Derived>& values, const char* what) {
  if (!values.allFinite()) throw Error(std::string(what) + ": must be finite");
}

}  // namespace tagcal::internal
