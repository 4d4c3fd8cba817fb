#include <cmath>
#include <limits>

#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal {
namespace {

// Derivatives of (position, azimuth, elevation, roll) by (omega, tau) of `retract`. The position is
// -R't, and R' exp(-omega) turns the body with axes forward, left, up, those of the camera z, -x,
// -y, by (-omega_z, omega_x, omega_y) about them; then as for any body's rates and angles (Diebel,
// Representing Attitude, 2006, section 5.6).
Matrix6 camera_by_step(const Pose& camera_from_target, const RollPitchYaw& angles) {
  const Eigen::Matrix3d target_from_camera = camera_from_target.rotation_matrix().transpose();
  Matrix6 by_step = Matrix6::Zero();
  by_step.topLeftCorner<3, 3>() =
      -target_from_camera * cross_matrix(camera_from_target.translation());
  by_step.topRightCorner<3, 3>() = -target_from_camera;
  const double sin_roll = std::sin(angles.roll_rad), cos_roll = std::cos(angles.roll_rad);
  const double sin_pitch = std::sin(angles.pitch_rad), cos_pitch = std::cos(angles.pitch_rad);
  const Eigen::RowVector3d azimuth = Eigen::RowVector3d(sin_roll, cos_roll, 0) / cos_pitch;
  by_step.block<1, 3>(3, 0) = azimuth;
  by_step.block<1, 3>(4, 0) = Eigen::RowVector3d(-cos_roll, sin_roll, 0);
  by_step.block<1, 3>(5, 0) = sin_pitch * azimuth - Eigen::RowVector3d(0, 0, 1);
  return by_step;
}

}  // namespace

CameraInTarget camera_in_target(const PoseHypothesis& hypothesis) {
  const Pose& camera_from_target = hypothesis.camera_from_target;
  const RollPitchYaw angles = camera_angles(camera_from_target);
  CameraInTarget camera;
  camera.position_m = camera_from_target.inverse().translation();
  camera.azimuth_rad = angles.yaw_rad;
  camera.elevation_rad = -angles.pitch_rad;
  camera.roll_rad = angles.roll_rad;
  camera.gimbal_lock = angles.gimbal_lock;
  const Matrix6 by_step = camera_by_step(camera_from_target, angles);
  camera.covariance = by_step * hypothesis.covariance * by_step.transpose();
  if (angles.gimbal_lock) {
    for (const Eigen::Index i : {3, 5}) {
      camera.covariance.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
      camera.covariance.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return camera;
}

}  // namespace tagcal
