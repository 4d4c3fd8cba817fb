#include "tagcal/uncertainty/rays/seen_ray.hpp"

#include <Eigen/LU>
#include <array>
#include <utility>

#include "tagcal/error.hpp"

namespace tagcal::internal {

using Eigen::Vector3d;

Eigen::Matrix<double, 3, 2> across(const Vector3d& direction) {
  Eigen::Index smallest = 0;
  direction.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = direction.cross(Vector3d::Unit(smallest)).normalized();
  basis.col(1) = direction.cross(basis.col(0));
  return basis;
}

// The pixel stays where it is while direction and parameters change: J_d dd = du - J_p dp.
std::optional<SeenRay> seen_ray(const Lens& lens, const Eigen::Vector2d& pixel,
                                std::span<const FreeParameter> free) {
  if (!kind_of(lens).is_central) throw Error("a parallel lens has no rays from one centre");
  const std::optional<Ray> ray = ray_in_camera(lens, pixel);
  if (!ray) return std::nullopt;
  const std::array<Vector3d, 1> points = {ray->direction};
  auto rows = projection_rows(lens, Pose(), points, free);
  if (!rows) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> basis = across(ray->direction);
  const Eigen::Matrix2d by_direction = rows->by_pose.rightCols<3>() * basis;
  return SeenRay{ray->direction, basis * by_direction.inverse(), rows->by_pose,
                 std::move(rows->by_parameters)};
}

}  // namespace tagcal::internal
