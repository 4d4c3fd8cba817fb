#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/lens_parameters.hpp"

namespace tagcal {
using namespace internal;

using Eigen::Vector2d;
using Eigen::Vector3d;

Parallel::Parallel(const Parameters& parameters) : p_(checked<Parallel>(parameters)) {}

bool Parallel::in_domain(const Vector3d& x_in_camera) const { return x_in_camera.allFinite(); }

std::optional<Vector2d> Parallel::project(const Vector3d& x_in_camera) const {
  return project(x_in_camera, nullptr, nullptr);
}

std::optional<Vector2d> Parallel::project(const Vector3d& x_in_camera, PointJacobian* by_point,
                                          ParameterJacobian* by_parameters) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  if (by_point) *by_point << p_[0], 0, 0, 0, p_[1], 0;
  if (by_parameters) *by_parameters << x_in_camera.x(), 0, 1, 0, 0, x_in_camera.y(), 0, 1;
  return Vector2d(p_[0] * x_in_camera.x() + p_[2], p_[1] * x_in_camera.y() + p_[3]);
}

std::optional<Ray> Parallel::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  return Ray{{(pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1], 0}, Vector3d::UnitZ()};
}

}  // namespace tagcal
