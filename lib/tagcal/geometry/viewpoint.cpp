#include "tagcal/geometry/viewpoint.hpp"

#include <cmath>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/internal/finite.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Cosines of the elevation below which an axis is vertical: for the warning, and to rounding.
constexpr double kNearlyVertical = 1e-6;
constexpr double kVertical = 1e-14;

void check_distance(double distance_m, const char* what) {
  require_finite(distance_m, what);
  if (!(distance_m > 0)) throw Error(std::string(what) + ": must be > 0");
}

// The columns are the camera's axes in the world.
Matrix3d axes_in_world(const Pose& camera_from_world) {
  require_finite(camera_from_world.matrix(), "pose");
  return camera_from_world.rotation_matrix().transpose();
}

// The angles of the matrix Rz(yaw) Ry(pitch) Rx(roll). The roll is computed after removing the yaw,
// so that the three reproduce the matrix even if its yaw is mostly rounding.
RollPitchYaw angles_of(const Matrix3d& m) {
  const double level = std::hypot(m(0, 0), m(1, 0));
  RollPitchYaw angles;
  angles.gimbal_lock = level < kNearlyVertical;
  angles.pitch_rad = std::atan2(-m(2, 0), level);
  angles.yaw_rad = level < kVertical ? std::atan2(-m(0, 1), m(1, 1)) : std::atan2(m(1, 0), m(0, 0));
  const double c = std::cos(angles.yaw_rad), s = std::sin(angles.yaw_rad);
  angles.roll_rad = std::atan2(s * m(0, 2) - c * m(1, 2), c * m(1, 1) - s * m(0, 1));
  return angles;
}

}  // namespace

Pose camera_from_world_looking_at(const Vector3d& eye, const Vector3d& target, const Vector3d& up) {
  for (const Vector3d& given : {eye, target, up}) require_finite(given, "look-at");
  const Vector3d view = target - eye;
  if (!(view.norm() > 0)) throw Error("look-at: the eye and the target coincide");
  const Vector3d forward = view.normalized();
  const Vector3d right = forward.cross(up);
  if (!(right.norm() > 1e-9 * up.norm())) throw Error("look-at: up is parallel to the view");
  Matrix3d world_from_camera;
  world_from_camera.col(0) = right.normalized();
  world_from_camera.col(1) = forward.cross(world_from_camera.col(0));  // down
  world_from_camera.col(2) = forward;
  return Pose(Quaterniond(world_from_camera), eye).inverse();
}

LookAt look_at(const Pose& camera_from_world, double distance_m) {
  check_distance(distance_m, "look-at: distance");
  const Matrix3d axes = axes_in_world(camera_from_world);
  const Vector3d eye = camera_from_world.inverse().translation();
  return {eye, eye + distance_m * axes.col(2), -axes.col(1)};
}

Pose camera_from_world_with_axes(const Matrix3d& axes, const Vector3d& centre) {
  require_finite(axes, "camera axes");
  require_finite(centre, "camera centre");
  return Pose(rotation_from_matrix(axes, "camera axes: their matrix"), centre).inverse();
}

Pose camera_from_world_on_orbit(const Orbit& orbit) {
  check_distance(orbit.distance_m, "orbit: distance");
  constexpr double kQuarter = std::numbers::pi / 2;
  // The camera stands in the target looking up, is tilted about its x, and steps back.
  return rotation_about_z(orbit.twist_rad) * translation({0, 0, orbit.distance_m}) *
         rotation_about_x(kQuarter + orbit.elevation_rad) *
         rotation_about_z(-kQuarter - orbit.azimuth_rad) * translation(-orbit.target);
}

Orbit orbit(const Pose& camera_from_world, double distance_m) {
  const Matrix3d axes = axes_in_world(camera_from_world);
  const Vector3d right = axes.col(0), down = axes.col(1), back = -axes.col(2);
  Orbit orbit;
  orbit.target = look_at(camera_from_world, distance_m).target;
  orbit.distance_m = distance_m;
  const double level = std::hypot(back.x(), back.y());
  orbit.gimbal_lock = level < kNearlyVertical;
  orbit.elevation_rad = std::atan2(back.z(), level);
  orbit.azimuth_rad =
      level < kVertical ? std::atan2(-right.x(), right.y()) : std::atan2(back.y(), back.x());
  const Vector3d right_untwisted(-std::sin(orbit.azimuth_rad), std::cos(orbit.azimuth_rad), 0);
  orbit.twist_rad = std::atan2(down.dot(right_untwisted), right.dot(right_untwisted));
  return orbit;
}

Quaterniond rotation_from_roll_pitch_yaw(const RollPitchYaw& angles) {
  return (rotation_about_z(angles.yaw_rad) * rotation_about_y(angles.pitch_rad) *
          rotation_about_x(angles.roll_rad))
      .rotation();
}

RollPitchYaw roll_pitch_yaw(const Quaterniond& rotation) {
  return angles_of(axes_in_world(Pose(rotation, Vector3d::Zero()).inverse()));
}

namespace {

// From the axes x forward, y left, z up.
Pose camera_from_body() {
  return {Quaterniond((Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished()), Vector3d::Zero()};
}

}  // namespace

Pose camera_from_world_with_angles(const RollPitchYaw& angles, const Vector3d& centre) {
  return camera_from_body() * Pose(rotation_from_roll_pitch_yaw(angles), centre).inverse();
}

RollPitchYaw camera_angles(const Pose& camera_from_world) {
  return roll_pitch_yaw((camera_from_body().inverse() * camera_from_world).inverse().rotation());
}

Pose world_from_aircraft(const Aircraft& aircraft) {
  const Pose attitude = rotation_about_z(aircraft.yaw_rad) * rotation_about_x(aircraft.pitch_rad) *
                        rotation_about_y(aircraft.roll_rad);
  return translation(cartesian_from_spherical(aircraft.position)) * attitude;
}

Aircraft aircraft(const Pose& world_from_aircraft) {
  // In axes x forward, y left, z up the aircraft's pitch is about -y.
  Matrix3d aircraft_from_body;
  aircraft_from_body << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Matrix3d m = axes_in_world(world_from_aircraft.inverse());
  const RollPitchYaw angles = angles_of(aircraft_from_body.transpose() * m * aircraft_from_body);
  return {spherical_from_cartesian(world_from_aircraft.translation()), angles.yaw_rad,
          -angles.pitch_rad, angles.roll_rad, angles.gimbal_lock};
}

Pose camera_from_aircraft() { return rotation_about_x(std::numbers::pi / 2); }

Pose camera_from_world_in_aircraft(const Aircraft& aircraft) {
  return camera_from_aircraft() * world_from_aircraft(aircraft).inverse();
}

Pose opengl_from_opencv() { return {Quaterniond(0, 1, 0, 0), Vector3d::Zero()}; }

}  // namespace tagcal
