#include "tagcal/scene/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

struct PlaceOnPath {
  Vector3d eye;
  Vector3d target;
};

Vector3d eye_of(const Orbit& orbit) {
  return camera_from_world_on_orbit(orbit).inverse().translation();
}

PlaceOnPath sight(const RingPath& path, double i, int n) {
  const double turn = path.end_rad - path.start_rad;
  const bool closed = std::abs(std::abs(turn) - 2 * std::numbers::pi) < 1e-9;
  const double t = closed ? i / n : time_of_view(i, n);
  return {eye_of({path.centre, path.radius_m, path.start_rad + t * turn, 0}), path.target};
}

// A step through 0 .. n-1 that visits each index once and jumps by about the golden ratio, so that
// the distance on a dome, which grows with the view, is not correlated with the elevation.
int golden_stride(int n) {
  int stride = std::max(1, static_cast<int>(std::lround(n * (std::numbers::phi - 1))));
  while (std::gcd(stride, n) != 1) ++stride;
  return stride;
}

PlaceOnPath sight(const DomePath& path, int i, int n) {
  const auto point = static_cast<double>(static_cast<std::int64_t>(i) * golden_stride(n) % n);
  const double turns = point * std::numbers::phi;
  const double azimuth =
      std::lerp(path.min_azimuth_rad, path.max_azimuth_rad, turns - std::floor(turns));
  // Equal steps of the sine have equal areas.
  const double sine = std::lerp(std::sin(path.min_elevation_rad), std::sin(path.max_elevation_rad),
                                (point + 0.5) / n);
  const double distance = std::lerp(path.min_distance_m, path.max_distance_m, time_of_view(i, n));
  return {eye_of({path.target, distance, azimuth, std::asin(sine)}), path.target};
}

PlaceOnPath sight(const LinePath& path, double i, int n) {
  return {path.from + time_of_view(i, n) * (path.to - path.from), path.target};
}

Vector3d jitter_vector(Random& random, double most) {
  const double x = random.uniform(-most, most);
  const double y = random.uniform(-most, most);
  return {x, y, random.uniform(-most, most)};
}

struct Shift {
  Vector3d eye;
  Vector3d target;
  double roll_rad;
};

Shift random_shift(const PathJitter& jitter, std::uint64_t seed, int view) {
  Random random(seed, static_cast<std::uint64_t>(view));
  const Vector3d eye = jitter_vector(random, jitter.position_m);
  const Vector3d target = jitter_vector(random, jitter.target_m);
  return {eye, target, random.uniform(-jitter.roll_rad, jitter.roll_rad)};
}

Pose looking_at(const PlaceOnPath& sight) {
  const Vector3d view = (sight.target - sight.eye).normalized();
  const bool along_z = view.cross(Vector3d::UnitZ()).norm() < 1e-9;
  return camera_from_world_looking_at(sight.eye, sight.target,
                                      along_z ? Vector3d::UnitY() : Vector3d::UnitZ());
}

template <typename Path>
Pose pose_on(const Path& path, int view, int num_views, const Shift& shift) {
  const PlaceOnPath on_path = sight(path, view, num_views);
  return rotation_about_z(shift.roll_rad) *
         looking_at({on_path.eye + shift.eye, on_path.target + shift.target});
}

Pose shifted(const Pose& camera_from_world, const Shift& shift) {
  if (shift.eye.isZero(0) && shift.target.isZero(0) && shift.roll_rad == 0)
    return camera_from_world;  // to the last bit
  const Pose world_from_camera = camera_from_world.inverse();
  const Vector3d axis = world_from_camera.rotation() * Vector3d::UnitZ();
  const Vector3d aim = axis + shift.target - shift.eye;
  const auto turn = rotation_between(axis, aim);
  const Pose moved(turn * world_from_camera.rotation(),
                   world_from_camera.translation() + shift.eye);
  return rotation_about_z(shift.roll_rad) * moved.inverse();
}

Pose pose_on(const ExplicitPath& path, int view, int /*num_views*/, const Shift& shift) {
  return shifted(path.camera_from_world[static_cast<std::size_t>(view)], shift);
}

Pose pose_on(const FunctionPath& path, int view, int num_views, const Shift& shift) {
  return shifted(path.camera_from_world(time_of_view(view, num_views)), shift);
}

}  // namespace

double RollingShutter::seconds_at(const Eigen::Vector2d& pixel, const ImageSize& size) const {
  const double share = by_rows() ? (pixel.y() + 0.5) / size.height : (pixel.x() + 0.5) / size.width;
  const bool forwards = direction == ReadDirection::down || direction == ReadDirection::right;
  return readout_s * (forwards ? share - 0.5 : 0.5 - share);
}

Pose moved_for(double seconds, const CameraVelocity& velocity, const Pose& camera_from_world) {
  Vector6d twist;
  twist << velocity.turn_rad_s, velocity.move_m_s;
  return exp_pose(-seconds * twist) * camera_from_world;
}

double time_of_view(double view, int num_views) {
  return num_views > 1 ? view / (num_views - 1) : 0;
}

std::optional<Pose> pose_between_views(const Scene& scene, double view) {
  if (const auto* path = std::get_if<FunctionPath>(&scene.path))
    return path->camera_from_world(time_of_view(view, scene.num_views));
  if (const auto* path = std::get_if<RingPath>(&scene.path))
    return looking_at(sight(*path, view, scene.num_views));
  if (const auto* path = std::get_if<LinePath>(&scene.path))
    return looking_at(sight(*path, view, scene.num_views));
  return std::nullopt;
}

std::vector<Pose> camera_poses(const Scene& scene, std::uint64_t seed) {
  if (scene.num_views < 1)
    throw Error(fmt::format("scene: views: must be > 0, got {}", scene.num_views));
  if (const auto* path = std::get_if<ExplicitPath>(&scene.path)) {
    if (static_cast<std::size_t>(scene.num_views) > path->camera_from_world.size())
      throw Error(fmt::format("scene: views: must be at most the {} poses of the path, got {}",
                              path->camera_from_world.size(), scene.num_views));
  }
  std::vector<Pose> poses;
  for (int view = 0; view < scene.num_views; ++view) {
    const Shift shift = random_shift(scene.jitter, seed, view);
    poses.push_back(std::visit(
        [&](const auto& path) { return pose_on(path, view, scene.num_views, shift); }, scene.path));
  }
  return poses;
}

std::string image_name(int view) { return fmt::format("{:03}.png", view); }

std::uint64_t noise_seed(std::uint64_t seed, int view) {
  return Random(seed, static_cast<std::uint64_t>(view)).next();
}

}  // namespace tagcal
