#pragma once

#include "tagcal/geometry/pose.hpp"
#include "tagcal/geometry/transform.hpp"

// The common parametrisations of a camera's position and attitude, converted to camera_from_world
// and back. Camera axes: x right, y down, z forward. All functions throw Error on numbers that are
// not finite.

namespace tagcal {

// The pose of a camera at `eye` that looks at `target`, image upright with respect to `up`, all in
// world coordinates. Throws Error if eye and target coincide or if up is parallel to the view (to
// within 1e-9 rad).
Pose camera_from_world_looking_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                                  const Eigen::Vector3d& up);

// The eye, a target `distance_m` > 0 ahead of it, and the up direction of the image, perpendicular
// to the view.
struct LookAt {
  Eigen::Vector3d eye;
  Eigen::Vector3d target;
  Eigen::Vector3d up;
};
LookAt look_at(const Pose& camera_from_world, double distance_m);

// The pose from the camera's centre and its axes right, down and forward (the columns), in world
// coordinates. Inexact axes become the nearest rotation; throws Error if they are left-handed or
// too inexact (rotation_from_matrix: |A'A - 1| >= kRotationTolerance). The way back is the
// rotation_matrix() and translation() of world_from_camera.
Pose camera_from_world_with_axes(const Eigen::Matrix3d& axes, const Eigen::Vector3d& centre);

// A camera on a sphere about a target that looks at its centre: azimuth about the world's z from +x
// towards +y, elevation from the ground towards +z, and a twist by which the image turns clockwise
// (the camera counter-clockwise). At twist 0 image up is the direction of growing elevation, so
// that no view is degenerate: straight down, image up is the world's -(cos azimuth, sin azimuth,
// 0).
struct Orbit {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  double distance_m = 1;  // > 0, else Error
  double azimuth_rad = 0;
  double elevation_rad = 0;
  double twist_rad = 0;
  bool gimbal_lock = false;  // set only in results: straight up or down, as in RollPitchYaw
};
Pose camera_from_world_on_orbit(const Orbit& orbit);

// The orbit of a pose about the point `distance_m` > 0 ahead. Azimuth and twist in (-pi, pi],
// elevation in [-pi/2, pi/2]; straight up or down, where only the sum or the difference of azimuth
// and twist is fixed, the twist is 0.
Orbit orbit(const Pose& camera_from_world, double distance_m);

// Roll about x, then pitch about y, then yaw about z, the fixed axes (equally yaw, pitch, roll
// about the body's own): Rz(yaw) Ry(pitch) Rx(roll). With x forward, y left, z up, as in robotics.
struct RollPitchYaw {
  double roll_rad = 0;
  double pitch_rad = 0;
  double yaw_rad = 0;
  // Set only in results: x points up (pitch = -pi/2) or down (pi/2) to within 1e-6 rad. Roll and
  // yaw are then about the same axis, and only their sum (up) or yaw - roll (down) is well defined.
  // The angles are one valid choice, with roll 0 if x is vertical to rounding.
  bool gimbal_lock = false;
};
Eigen::Quaterniond rotation_from_roll_pitch_yaw(const RollPitchYaw& angles);

// Roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2].
RollPitchYaw roll_pitch_yaw(const Eigen::Quaterniond& rotation);

// A camera at `centre` that looks along x of a body with these angles, z of the body up in the
// image; and the angles of a camera.
Pose camera_from_world_with_angles(const RollPitchYaw& angles, const Eigen::Vector3d& centre);
RollPitchYaw camera_angles(const Pose& camera_from_world);

// An aircraft at (rho, theta, phi), with axes x right, y forward, z up and its attitude relative to
// the world's axes: yaw about z (left), pitch about x (nose up), roll about y (right wing down):
// world_from_aircraft =
//   Rz(phi) Ry(theta) T(0, 0, rho) Ry(-theta) Rz(-phi) Rz(yaw) Rx(pitch) Ry(roll).
struct Aircraft {
  Spherical position;
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
  bool gimbal_lock = false;  // set only in results: straight up or down, as in RollPitchYaw
};
Pose world_from_aircraft(const Aircraft& aircraft);
Aircraft aircraft(const Pose& world_from_aircraft);

// The camera of the pilot, in the aircraft's origin, looking along its y axis, z up in the image.
Pose camera_from_aircraft();
Pose camera_from_world_in_aircraft(const Aircraft& aircraft);

// The camera axes of OpenGL (x right, y up, looking along -z) and those of OpenCV and this library:
// half a turn about x, which is its own inverse.
Pose opengl_from_opencv();
inline Pose opencv_from_opengl() { return opengl_from_opencv(); }

}  // namespace tagcal
