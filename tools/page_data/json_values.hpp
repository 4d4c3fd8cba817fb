#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::tools {

using PageJson = nlohmann::ordered_json;

// A number with this many significant digits, or decimals; null if it is not finite.
PageJson significant(double value, int digits = 6);
PageJson decimals(double value, int digits);

PageJson point_json(const Eigen::Vector2d& pixel);     // to 0.01 px
PageJson point_json(const Eigen::Vector3d& x_in_m);    // to 0.01 mm
PageJson matrix_json(const Pose& target_from_source);  // 4 x 4
PageJson grid_json(const MatrixX& values);             // to 4 digits; null: not finite

}  // namespace tagcal::tools
