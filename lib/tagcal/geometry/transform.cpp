#include "tagcal/geometry/transform.hpp"

#include <Eigen/LU>
#include <cmath>

#include "tagcal/internal/finite.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

// Bound on the rounding error of a minor that is zero.
constexpr double kRounding = 1e-14;

Vector3d unit_axis(const Vector3d& axis, const char* what) {
  require_finite(axis, what);
  if (axis.isZero(0)) throw Error(std::string(what) + ": must not be zero");
  return axis.stableNormalized();
}

Pose turn(const Vector3d& unit, double angle_rad) {
  require_finite(angle_rad, "rotation: angle");
  return {exp_rotation(angle_rad * unit), Vector3d::Zero()};
}

template <int N>
Eigen::Matrix<double, N, N> cofactors(const Eigen::Matrix<double, N, N>& matrix) {
  Eigen::Matrix<double, N, N> result;
  for (int row = 0; row < N; ++row) {
    for (int column = 0; column < N; ++column) {
      Eigen::Matrix<double, N - 1, N - 1> rest;
      for (int i = 0; i < N - 1; ++i)
        for (int j = 0; j < N - 1; ++j)
          rest(i, j) = matrix(i < row ? i : i + 1, j < column ? j : j + 1);
      result(row, column) = (row + column) % 2 == 0 ? rest.determinant() : -rest.determinant();
    }
  }
  return result;
}

}  // namespace

Pose translation(const Vector3d& offset) {
  require_finite(offset, "translation");
  return {Quaterniond::Identity(), offset};
}

Pose rotation_about_x(double angle_rad) { return turn(Vector3d::UnitX(), angle_rad); }
Pose rotation_about_y(double angle_rad) { return turn(Vector3d::UnitY(), angle_rad); }
Pose rotation_about_z(double angle_rad) { return turn(Vector3d::UnitZ(), angle_rad); }

Pose rotation_about_axis(const Vector3d& axis, double angle_rad) {
  return turn(unit_axis(axis, "rotation: axis"), angle_rad);
}

Pose rotation_about_line(const Vector3d& point, const Vector3d& axis, double angle_rad) {
  require_finite(point, "rotation: point");
  const Quaterniond rotation = rotation_about_axis(axis, angle_rad).rotation();
  return {rotation, point - rotation * point};
}

Affine scaling(const Vector3d& factors) {
  require_finite(factors, "scaling: factors");
  Affine result = Affine::Identity();
  result.linear() = factors.asDiagonal();
  return result;
}

Affine scaling(double factor) { return scaling(Vector3d::Constant(factor)); }

Affine shearing(Axis along, Axis by, double factor) {
  require_finite(factor, "shearing: factor");
  if (along == by) throw Error("shearing: an axis cannot be sheared along itself");
  Affine result = Affine::Identity();
  result.matrix()(static_cast<int>(along), static_cast<int>(by)) = factor;
  return result;
}

Affine affine(const Pose& pose) {
  Affine result;
  result.matrix() = pose.matrix();
  return result;
}

Pose rigid(const Affine& transform) {
  require_finite(transform.matrix(), "transform");
  constexpr double kTolerance = 1e-9;
  return {rotation_from_matrix(transform.linear(), "transform: its linear part", kTolerance),
          transform.translation()};
}

Affine inverse_of(const Affine& transform) {
  require_finite(transform.matrix(), "transform");
  Eigen::FullPivLU<Matrix3d> linear(transform.linear());
  linear.setThreshold(1e-12);
  if (!linear.isInvertible()) throw Error("transform: it is singular and has no inverse");
  Affine result = Affine::Identity();
  result.linear() = linear.inverse();
  result.translation() = -(result.linear() * transform.translation());
  return result;
}

Pose aligning_with_x(const Vector3d& axis) {
  const Vector3d unit = unit_axis(axis, "alignment: axis");
  const double across = std::hypot(unit.y(), unit.z());
  return rotation_about_z(-std::atan2(across, unit.x())) *
         rotation_about_x(-std::atan2(unit.z(), unit.y()));
}

Pose aligning_with_x(const Vector3d& axis, const Vector3d& across) {
  Matrix3d rows;
  rows.row(0) = unit_axis(axis, "alignment: axis");
  const Vector3d normal = rows.row(0).cross(unit_axis(across, "alignment: second axis"));
  if (normal.norm() < 1e-9) throw Error("alignment: the second axis is parallel to the first");
  rows.row(1) = normal.normalized();
  rows.row(2) = rows.row(0).cross(rows.row(1));
  return {Quaterniond(rows), Vector3d::Zero()};
}

Polar polar_from_cartesian(const Vector2d& x) {
  require_finite(x, "point");
  // + 0.0 makes -0 a 0; for -0, atan2 returns the other side of the cut.
  return {std::hypot(x.x(), x.y()), std::atan2(x.y() + 0.0, x.x() + 0.0)};
}

Vector2d cartesian_from_polar(const Polar& polar) {
  require_finite(Vector2d(polar.rho, polar.theta_rad), "polar coordinates");
  return polar.rho * Vector2d(std::cos(polar.theta_rad), std::sin(polar.theta_rad));
}

Spherical spherical_from_cartesian(const Vector3d& x) {
  require_finite(x, "point");
  const Polar on_ground = polar_from_cartesian(x.head<2>());
  return {std::hypot(x.x(), x.y(), x.z()), std::atan2(on_ground.rho, x.z() + 0.0),
          on_ground.theta_rad};
}

Vector3d cartesian_from_spherical(const Spherical& spherical) {
  const auto& [rho, theta, phi] = spherical;
  require_finite(Vector3d(rho, theta, phi), "spherical coordinates");
  const double sine = std::sin(theta);
  return rho * Vector3d(sine * std::cos(phi), sine * std::sin(phi), std::cos(theta));
}

Matrix3d cofactor_matrix(const Matrix3d& matrix) { return cofactors<3>(matrix); }
Matrix4d cofactor_matrix(const Matrix4d& matrix) { return cofactors<4>(matrix); }

Vector4d transformed_plane(const Matrix4d& target_from_source, const Vector4d& plane_in_source) {
  require_finite(target_from_source, "transform");
  require_finite(plane_in_source, "plane");
  if (plane_in_source.head<3>().isZero(0)) throw Error("plane: its normal must not be zero");
  const Vector4d plane = plane_in_source.stableNormalized();
  const Matrix4d cofactor = cofactor_matrix(target_from_source);
  const Vector4d image = cofactor * plane;
  if (!(image.norm() > kRounding * cofactor.norm()))
    throw Error("plane: the transform leaves no plane of it");
  const double length = image.head<3>().norm();
  if (!(length > kRounding * image.norm()))
    throw Error("plane: the transform takes it to infinity");
  const bool mirrored = target_from_source.row(0).dot(cofactor.row(0)) < 0;
  return image / (mirrored ? -length : length);
}

Line transformed_line(const Affine& target_from_source, const Line& line_in_source) {
  const Vector3d along = line_in_source.b - line_in_source.a;
  require_finite(along, "line");
  require_finite(target_from_source.matrix(), "transform");
  if (along.isZero(0)) throw Error("line: its two points coincide");
  const double length = (target_from_source.linear() * along).norm();
  if (!(length > kRounding * target_from_source.linear().norm() * along.norm()))
    throw Error("line: the transform takes its two points to one");
  return {target_from_source * line_in_source.a, target_from_source * line_in_source.b};
}

}  // namespace tagcal
