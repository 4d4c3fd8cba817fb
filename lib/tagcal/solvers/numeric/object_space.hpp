#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/numeric/point_frame.hpp"

// The error of a pose in the space of the object (Lu, Hager & Mjolsness, PAMI 2000, eq. 19), whose
// translation is eliminated: a quadratic form in the nine numbers of the rotation alone (Terzakis &
// Lourakis, ECCV 2020, eqs. 5-9), and the descent to its minima over SO(3). The inside of `pnp`.

namespace tagcal::internal {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix39 = Eigen::Matrix<double, 3, 9>;

// With points taken to their own frame and rays to theirs (z along their mean), r the columns of R
// one below the other:
//   r' omega r = min_t 1/n sum_i |(1 - v_i v_i') (R x_i + t)|^2,  t = translation_map r,
// and the mean of v_i' (R x_i + t), the distance along the rays, is depth_map . r.
struct ObjectSpaceError {
  Matrix9 omega;
  Matrix39 translation_map;
  Vector9 depth_map;

  PointFrame frame;
  Eigen::Matrix3d rays_from_camera;  // rotation

  Pose camera_from_target(const Eigen::Quaterniond& rays_from_points) const;
};

// No value where the points have no frame, the rays coincide (to within 1e-9 rad), or a number is
// not finite. A ray of length zero is not.
std::optional<ObjectSpaceError> object_space_error(std::span<const Eigen::Vector3d> points,
                                                   std::span<const Eigen::Vector3d> rays);

// A rotation (unit quaternion) and r' omega r there.
struct RotationMinimum {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double error = 0;
};

Vector9 columns_of(const Eigen::Quaterniond& rotation);

// The value of r' omega r / 2 at R exp(w): value + gradient . w + w' hessian w / 2 to second order.
struct RotationExpansion {
  double value = 0;
  Eigen::Vector3d gradient;
  Eigen::Matrix3d hessian;
};
RotationExpansion expansion(const Matrix9& omega, const Vector9& r);

// Damped Newton steps from a rotation down to a minimum. No value where the steps do not settle on
// one that is isolated (its Hessian positive).
std::optional<RotationMinimum> descend(const Matrix9& omega, const Eigen::Quaterniond& start);

}  // namespace tagcal::internal
