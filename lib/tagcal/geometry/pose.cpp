#include "tagcal/geometry/pose.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

// Below this angle the Taylor series are exact to the last digit, and the quotients are not.
constexpr double kSmallAngle = 1e-3;

// (1 - cos a) / a^2
double one_minus_cos_over_square(double a) {
  if (a < kSmallAngle) return 0.5 - a * a / 24;
  const double s = std::sin(a / 2) / a;
  return 2 * s * s;
}

// (a - sin a) / a^3
double a_minus_sin_over_cube(double a) {
  if (a < 0.1) {
    const double s = a * a;
    return 1.0 / 6 - s / 120 + s * s / 5040 - s * s * s / 362880;
  }
  return (a - std::sin(a)) / (a * a * a);
}

// (1 - (a / 2) cot(a / 2)) / a^2: the coefficient of the inverse left Jacobian.
double inverse_jacobian_coefficient(double a) {
  if (a < 0.1) {
    const double s = a * a;
    return 1.0 / 12 + s / 720 + s * s / 30240 + s * s * s / 1209600;
  }
  return (1 - 0.5 * a / std::tan(0.5 * a)) / (a * a);
}

}  // namespace

Eigen::Matrix4d Pose::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation_matrix();
  m.topRightCorner<3, 1>() = translation_;
  return m;
}

Pose Pose::inverse() const {
  const Eigen::Quaterniond inverse_rotation = rotation().conjugate();
  return {inverse_rotation, -(inverse_rotation * translation_)};
}

Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  // sin(a / 2) / a, whose series starts 1/2 - a^2 / 48
  const double k = angle < kSmallAngle ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  Eigen::Quaterniond q(std::cos(angle / 2), k * v.x(), k * v.y(), k * v.z());
  return q.normalized();
}

// Not inline: Eigen's template compiles a singular value decomposition into every file that uses
// it.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const double w = sign * q.w();
  const Eigen::Vector3d axis_sine = sign * q.vec();
  const double sine = axis_sine.norm();
  if (sine < 1e-150) return 2 * axis_sine;  // w = 1: v = 2 vec(q); the norm may underflow
  return 2 * std::atan2(sine, w) / sine * axis_sine;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& v) {
  const Eigen::Matrix3d w = cross_matrix(v);
  const double angle = v.norm();
  return Eigen::Matrix3d::Identity() + one_minus_cos_over_square(angle) * w +
         a_minus_sin_over_cube(angle) * w * w;
}

Pose exp_pose(const Vector6d& twist) {
  const Eigen::Vector3d omega = twist.head<3>();
  return {exp_rotation(omega), left_jacobian(omega) * twist.tail<3>()};
}

Vector6d log_pose(const Pose& pose) {
  const Eigen::Vector3d omega = log_rotation(pose.rotation());
  const Eigen::Matrix3d w = cross_matrix(omega);
  const Eigen::Matrix3d v_inverse =
      Eigen::Matrix3d::Identity() - 0.5 * w + inverse_jacobian_coefficient(omega.norm()) * w * w;
  Vector6d twist;
  twist << omega, v_inverse * pose.translation();
  return twist;
}

Pose retract(const Pose& pose, const Vector6d& step) {
  return {exp_rotation(step.head<3>()) * pose.rotation(), pose.translation() + step.tail<3>()};
}

Vector6d minus(const Pose& to, const Pose& from) {
  Vector6d step;
  step << log_rotation(to.rotation() * from.rotation().conjugate()),
      to.translation() - from.translation();
  return step;
}

double angle_between_rad(const Pose& a, const Pose& b) {
  return log_rotation(a.rotation() * b.rotation().conjugate()).norm();
}

double distance_between_m(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm();
}

Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return Eigen::Quaterniond(rotation).normalized();
}

Eigen::Quaterniond rotation_from_matrix(const Eigen::Matrix3d& matrix, std::string_view what,
                                        double tolerance) {
  const double error = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).norm();
  const double determinant = matrix.determinant();
  if (!(error < tolerance) || determinant < 0) {
    throw Error(fmt::format("{} must be a rotation, but |R'R - 1| is {:.3g}, det R is {:.3g}", what,
                            error, determinant));
  }
  return nearest_rotation(matrix);
}

}  // namespace tagcal
