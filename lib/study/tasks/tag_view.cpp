#include "study/tasks/tag_view.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::study {

using Eigen::Vector2d;
using Eigen::Vector3d;

TagScene::TagScene(const TagViewSpec& spec, Random& random)
    : families({{spec.family, tag_family(spec.family, 1)}}),
      id(static_cast<int>(random.index(families.at(spec.family).codes.size()))) {
  scene.boards.push_back({make_board(spec.board(id)), Pose()});
  scene.sensor = {1, spec.blur_px, spec.noise_levels};
  scene.paper_level = 220 / 255.0;
  scene.ink_level = 30 / 255.0;
  scene.paper_margin_m = 2;
}

std::optional<std::array<Vector2d, 4>> TagScene::corners(const Pose& camera_from_world) const {
  std::array<Vector2d, 4> result;
  const auto corners = tag_corners(tags_of(scene.boards[0].board)[0]);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = project(scene.camera.lens, camera_from_world * corners[i]);
    if (!pixel) return std::nullopt;
    result[i] = *pixel;
  }
  return result;
}

TagView TagScene::view(const Pose& camera_from_world, Random& random) const {
  TagView view{id, corners(camera_from_world).value(), {}, {}, scene.camera};
  const ImageF light = render_light(scene, families, camera_from_world);
  view.image = expose(light, scene.sensor, random.next());
  Sensor quiet = scene.sensor;
  quiet.noise_levels = 0;
  view.noiseless = expose(light, quiet, 0);
  return view;
}

Pose tag_pose(const Vector3d& direction, double distance, double tilt_deg,
              const Vector2d& azimuth_and_roll) {
  const double azimuth = azimuth_and_roll.x();
  const Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
  const Eigen::AngleAxisd tilt(internal::radians(tilt_deg), axis);
  const Eigen::AngleAxisd roll(azimuth_and_roll.y(), Vector3d::UnitZ());
  const Eigen::AngleAxisd facing(std::numbers::pi, Vector3d::UnitX());
  const auto ahead = rotation_between(Vector3d::UnitZ(), direction);
  const Eigen::Quaterniond rotation(ahead * tilt * roll * facing);
  return Pose(rotation, distance * direction - rotation * Vector3d(0.5, 0.5, 0));
}

Vector2d random_turns(Random& random) {
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  return {azimuth, random.uniform(0, 2 * std::numbers::pi)};
}

TagView rendered_tag(const TagViewSpec& spec, Random& random) {
  constexpr double kFocal = 900;
  TagScene tag(spec, random);
  const int width = static_cast<int>(2.4 * spec.side_px) + 24;
  const double middle = 0.5 * (width - 1);
  tag.scene.camera = {pinhole(kFocal, kFocal, middle + random.uniform(-0.5, 0.5),
                              middle + random.uniform(-0.5, 0.5)),
                      {width, width}};
  const Pose pose =
      tag_pose(Vector3d::UnitZ(), kFocal / spec.side_px, spec.tilt_deg, random_turns(random));
  return tag.view(pose, random);
}

}  // namespace tagcal::study
