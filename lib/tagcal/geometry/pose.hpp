#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string_view>

#include "tagcal/language.hpp"

namespace tagcal {

using Vector6d = Eigen::Matrix<double, 6, 1>;

// Eigen's alignment depends on the compiler's -m flags (-mavx2: 32 bytes, else 16), so a program
// with other flags than the library would lay out structs differently. The target tagcal::tagcal
// defines the macro.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16 && (EIGEN_MAX_STATIC_ALIGN_BYTES == 16 ||
                                              !(EIGEN_ARCH_i386_OR_x86_64 || EIGEN_ARCH_ARM64)),
              "tagcal is built with Eigen's alignment of 16 bytes: link the CMake target "
              "tagcal::tagcal, or compile with -DEIGEN_MAX_ALIGN_BYTES=16");

// Matrices kept in public structs are unaligned, so that a program built with other -m flags than
// the library lays them out the same way, and frees what the library allocated: only unaligned
// matrices of dynamic size come from malloc under all flags.
using Matrix2 = Eigen::Matrix<double, 2, 2, Eigen::DontAlign>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;
using MatrixX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign>;

// A rigid motion, named target_from_source: it takes coordinates in the source frame to coordinates
// in the target frame, x_in_target = R x_in_source + t. Poses compose by matching neighbours:
// camera_from_board = camera_from_world * world_from_board. Lengths in metres.
class Pose {
 public:
  Pose() = default;  // identity

  // The quaternion is normalised; it must not be zero. One that is unit to rounding stays as it is,
  // so that a pose written to a file and read back is the same to the last bit.
  Pose(const Eigen::Quaterniond& target_from_source, const Eigen::Vector3d& source_in_target)
      : rotation_(unit(target_from_source)), translation_(source_in_target) {}

  Eigen::Quaterniond rotation() const { return rotation_; }
  Eigen::Matrix3d rotation_matrix() const { return rotation_.toRotationMatrix(); }

  // The origin of the source frame, in the target frame.
  const Eigen::Vector3d& translation() const { return translation_; }

  // The 4x4 matrix for homogeneous column vectors.
  Eigen::Matrix4d matrix() const;

  Pose inverse() const;  // source_from_target

  // a_from_b * b_from_c = a_from_c
  Pose operator*(const Pose& b_from_c) const {
    return {rotation() * b_from_c.rotation(), *this * b_from_c.translation_};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_source) const {
    return rotation_ * x_in_source + translation_;
  }

 private:
  static Eigen::Quaterniond unit(const Eigen::Quaterniond& q) {
    // The error after normalising is at most 3 epsilon (20 million random quaternions).
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    return std::abs(q.squaredNorm() - 1) <= kRounding ? q : q.normalized();
  }

  Eigen::Quaternion<double, Eigen::DontAlign> rotation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

// Rotation by |v| radians about v / |v|, right-handed. Exact for any v, zero included.
Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& v);

// The smallest rotation from one direction to another, of any length except zero; for opposite
// directions, one of the half turns.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

// The shortest rotation vector of a unit quaternion: |log| <= pi. At an angle of exactly pi both
// signs of the axis are right; the sign of the quaternion with w >= 0 is returned.
Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q);

// J with exp_rotation(v + d) = exp_rotation(J d) exp_rotation(v) to first order in d (Barfoot,
// State Estimation for Robotics, eq. 7.77b). Singular only at |v| = 2 pi.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& v);

// The matrix of v x.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

// Exponential and logarithm of SE(3); the twist is (omega, v): rotation first, as in every 6-vector
// of this library. exp_pose(twist).translation() = V(omega) v (Barfoot, State Estimation for
// Robotics, eq. 7.86).
Pose exp_pose(const Vector6d& twist);
Vector6d log_pose(const Pose& pose);

// The step of estimators and of pose covariances: (omega, tau), both in the target frame,
// R <- exp(omega) R, t <- t + tau. `minus` is its inverse: retract(a, minus(b, a)) = b.
Pose retract(const Pose& pose, const Vector6d& step);
Vector6d minus(const Pose& to, const Pose& from);

// Angle of the rotation between two poses, in [0, pi], and distance between their translations.
double angle_between_rad(const Pose& a, const Pose& b);
double distance_between_m(const Pose& a, const Pose& b);

// The rotation nearest to a matrix (Frobenius norm; Schonemann 1966, with det = +1). The matrix
// must have rank 2 at least.
Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& matrix);

// The rotation nearest to a matrix R, if |R'R - 1| (Frobenius norm) is below the tolerance and
// det R > 0. Otherwise throws Error "`what` must be a rotation, but ...". The default tolerance
// accepts matrices that were rounded to three digits.
constexpr double kRotationTolerance = 1e-3;
Eigen::Quaterniond rotation_from_matrix(const Eigen::Matrix3d& matrix, std::string_view what,
                                        double tolerance = kRotationTolerance);

}  // namespace tagcal
