#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

// Matrices and vectors in the JSON of `tagcal view`, and a calibration for it.

namespace tagcal::tools {

inline constexpr const char* kCamera = R"(image_width: 1280
image_height: 800
camera_matrix: {rows: 3, cols: 3, dt: d, data: [902.5, 0, 651.2, 0, 901.3, 391.7, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [-0.15, 0.05, 0.0005, -0.0003, 0]}
)";

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
