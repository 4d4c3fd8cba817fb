#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include "tagcal/internal/degrees.hpp"

// Values of the report of `tagcal view`, as JSON.

namespace tagcal::tools {

using Json = nlohmann::ordered_json;

using internal::degrees;

// Zero instead of a number that is printed as "-0.000000".
inline double shown(double value) { return std::abs(value) < 0.5e-6 ? 0 : value; }

// The planes of a view volume, in the order of clip_planes.
inline constexpr const char* kPlaneNames[] = {"left", "right", "bottom", "top", "near", "far"};

template <typename Vector>
Json array(const Vector& v) {
  Json result = Json::array();
  for (const double x : v) result.push_back(x);
  return result;
}

template <typename Matrix>
Json rows(const Matrix& m) {
  Json result = Json::array();
  for (int r = 0; r < m.rows(); ++r) result.push_back(array(m.row(r)));
  return result;
}

template <typename Vector>
Json array_or_null(const std::optional<Vector>& v) {
  return v ? array(*v) : Json();
}

}  // namespace tagcal::tools
