#include "tagcal/camera/lens.hpp"

namespace tagcal {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::span<const double> parameters(const Lens& lens) {
  return std::visit([](const auto& l) { return std::span<const double>(l.parameters()); }, lens);
}

std::span<const std::string_view> parameter_names(const Lens& lens) {
  return std::visit(
      [](const auto& l) { return std::span<const std::string_view>(l.kParameterNames); }, lens);
}

bool in_domain(const Lens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.in_domain(x_in_camera); }, lens);
}

std::optional<Vector2d> project(const Lens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.project(x_in_camera); }, lens);
}

std::optional<Ray> ray_in_camera(const Lens& lens, const Vector2d& pixel) {
  return std::visit([&](const auto& l) { return l.ray_in_camera(pixel); }, lens);
}

}  // namespace tagcal
