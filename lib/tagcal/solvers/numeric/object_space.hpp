#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"

// Object-space error of a pose (Lu, Hager & Mjolsness, PAMI 2000, eq. 19) with eliminated
// translation: a quadratic form in the nine numbers of the rotation (Terzakis & Lourakis, ECCV
// 2020, eqs. 5-9), and the descent to its minima over SO(3). Used by `pnp`.

namespace tagcal::internal {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix39 = Eigen::Matrix<double, 3, 9>;

// Points are in their own frame, in units of their size, rays in theirs (z along their mean), and r
// is the columns of R one below the other:
//   r' omega r = min_t 1/n sum_i |(1 - v_i v_i') (R x_i + t)|^2,  t = translation_map r,
// and the mean of v_i' (R x_i + t), the distance along the rays, is depth_map . r.
struct ObjectSpaceError {
  Matrix9 omega;
  Matrix39 translation_map;
  Vector9 depth_map;

  PointSpread frame;
  Eigen::Matrix3d rays_from_camera;  // rotation

  Pose camera_from_target(const Eigen::Quaterniond& rays_from_points) const;
};

// No value if the points are not wide, the rays coincide (to within 1e-9 rad), a ray has length
// zero, or a number is not finite.
std::optional<ObjectSpaceError> object_space_error(std::span<const Eigen::Vector3d> points,
                                                   std::span<const Eigen::Vector3d> rays);

// A rotation (unit quaternion) and r' omega r there.
struct RotationMinimum {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double error = 0;
};

Vector9 columns_of(const Eigen::Quaterniond& rotation);

// Expansion of r' omega r / 2 at R exp(w) to second order: value + gradient . w + w' hessian w / 2.
struct RotationExpansion {
  double value = 0;
  Eigen::Vector3d gradient;
  Eigen::Matrix3d hessian;
};
RotationExpansion expansion(const Matrix9& omega, const Vector9& r);

// Descends from a rotation to a minimum by damped Newton steps. No value if the steps do not
// converge to an isolated one (positive definite Hessian).
std::optional<RotationMinimum> descend(const Matrix9& omega, const Eigen::Quaterniond& start);

}  // namespace tagcal::internal
