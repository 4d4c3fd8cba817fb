#include "page_data/json_values.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace tagcal::tools {

PageJson significant(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr);
}

PageJson decimals(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.{}f}", value, digits).c_str(), nullptr);
}

PageJson point_json(const Eigen::Vector2d& pixel) {
  return {decimals(pixel.x(), 2), decimals(pixel.y(), 2)};
}

PageJson point_json(const Eigen::Vector3d& x_in_m) {
  return {decimals(x_in_m.x(), 5), decimals(x_in_m.y(), 5), decimals(x_in_m.z(), 5)};
}

PageJson matrix_json(const Pose& target_from_source) {
  const Eigen::Matrix4d m = target_from_source.matrix();
  PageJson rows = PageJson::array();
  for (int row = 0; row < 4; ++row) {
    PageJson list = PageJson::array();
    for (int column = 0; column < 4; ++column) list.push_back(significant(m(row, column), 7));
    rows.push_back(std::move(list));
  }
  return rows;
}

PageJson grid_json(const MatrixX& values) {
  PageJson rows = PageJson::array();
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    PageJson list = PageJson::array();
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      list.push_back(significant(values(row, column), 4));
    rows.push_back(std::move(list));
  }
  return rows;
}

}  // namespace tagcal::tools
