#include "page_data/json_values.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace tagcal::tools {

namespace {

PageJson rows_json(const Eigen::MatrixXd& values, int digits) {
  PageJson rows = PageJson::array();
  for (const auto& row : values.rowwise()) {
    PageJson list = PageJson::array();
    for (const double value : row) list.push_back(significant(value, digits));
    rows.push_back(std::move(list));
  }
  return rows;
}

}  // namespace

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
  return rows_json(target_from_source.matrix(), 7);
}

PageJson grid_json(const MatrixX& values) { return rows_json(values, 4); }

}  // namespace tagcal::tools
