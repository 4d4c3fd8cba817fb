// Frames that move in other frames: a wheel, an aircraft, an orbit.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tagcal/geometry/viewpoint.hpp>
#include <tagcal/viewing/frames.hpp>

int main() {
  constexpr double kDegree = std::numbers::pi / 180;
  // The wheel of radius 0.5 m has rolled by 60 degrees.
  tagcal::Frames<tagcal::Pose> frames("world");
  frames.add({"axle", "world", tagcal::translation({-1 + 0.5 * 60 * kDegree, 0, 0.5})});
  frames.add({"wheel", "axle", tagcal::rotation_about_y(60 * kDegree)});
  frames.add({"bead", "wheel", tagcal::translation({0, 0, -0.4})});
  const Eigen::Vector3d bead = frames.a_from_b("world", "bead").translation();
  std::printf("bead at x %.4f, z %.4f\n", bead.x(), bead.z());

  // The aircraft: placed in the world, and the corner (1.75, -0.25, 0) seen by its pilot.
  const double a = std::atan2(3, 4);  // 36.87 degrees
  const tagcal::Aircraft aircraft{.position = {5, 90 * kDegree - a, a},
                                  .yaw_rad = 90 * kDegree + a,
                                  .pitch_rad = -a,
                                  .roll_rad = a};
  const Eigen::Vector3d place = tagcal::world_from_aircraft(aircraft).translation();
  const Eigen::Vector3d seen =
      tagcal::camera_from_world_in_aircraft(aircraft) * Eigen::Vector3d(1.75, -0.25, 0);
  std::printf("aircraft at %.4f %.4f %.4f, sees the corner at %.4f %.4f %.4f\n", place.x(),
              place.y(), place.z(), seen.x(), seen.y(), seen.z());

  // Straight above its target, an orbit turns the image by azimuth and twist alike.
  for (const double azimuth : {40.0, 10.0}) {
    const tagcal::Pose pose =
        tagcal::camera_from_world_on_orbit({.azimuth_rad = azimuth * kDegree,
                                            .elevation_rad = 90 * kDegree,
                                            .twist_rad = (30 - azimuth) * kDegree});
    const tagcal::Orbit orbit = tagcal::orbit(pose, 1);
    std::printf("azimuth %.0f, twist %.0f: azimuth %.1f, gimbal lock %s\n", azimuth, 30 - azimuth,
                orbit.azimuth_rad / kDegree, orbit.gimbal_lock ? "yes" : "no");
  }
}
