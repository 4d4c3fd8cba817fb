#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

// Matrices and vectors in the JSON of `tagcal view`.

namespace tagcal::tools {

inline Eigen::Matrix4d matrix(const nlohmann::json& rows) {
  Eigen::Matrix4d m;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) m(r, c) = rows[r][c];
  return m;
}

inline Eigen::VectorXd vector(const nlohmann::json& numbers) {
  Eigen::VectorXd v(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) v[static_cast<int>(i)] = numbers[i];
  return v;
}

}  // namespace tagcal::tools
