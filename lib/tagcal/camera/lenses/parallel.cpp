#include "tagcal/camera/lenses/lens_parameters.hpp"
#include "tagcal/camera/lenses/project_point.hpp"

namespace tagcal {
using namespace internal;

using Eigen::Vector2d;
using Eigen::Vector3d;

Parallel::Parallel(const Parameters& parameters) : p_(checked<Parallel>(parameters)) {}

bool Parallel::in_domain(const Vector3d& x_in_camera) const { return x_in_camera.allFinite(); }

std::optional<Vector2d> Parallel::project(const Vector3d& x_in_camera) const {
  return project_point<ParallelKernel>(*this, 0, x_in_camera);
}

std::optional<Vector2d> Parallel::project(const Vector3d& x_in_camera, PointJacobian* by_point,
                                          ParameterJacobian* by_parameters) const {
  return project_point<ParallelKernel>(*this, 0, x_in_camera, by_point, by_parameters);
}

std::optional<Ray> Parallel::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  return Ray{{(pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1], 0},
             Vector3d(-p_[4], -p_[5], 1).normalized()};
}

}  // namespace tagcal
