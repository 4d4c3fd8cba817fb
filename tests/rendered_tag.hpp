#pragma once

// Pictures of single plain tags by the library's own renderer, with their true corners.

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "tagcal/detect/families.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {

struct TagViewSpec {
  double side_px = 40;
  double tilt_deg = 30;
  double blur_px = 0.8;
  double noise_levels = 2;
  std::string family = "tag36h11";
  int border_bits = 1;
  bool corner_squares = false;  // Kalibr's, 0.3 of the tag wide
};

struct TagView {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
  Image8 image;
  Image8 noiseless;
  Camera camera;
};

// One tag on white, black 30, white 220, before a camera.
struct TagScene {
  TagFamilies families;
  Scene scene;
  int id = 0;

  TagScene(const TagViewSpec& spec, Random& random)
      : families({{spec.family, tag_family(spec.family, 1)}}),
        id(static_cast<int>(random.index(families.at(spec.family).codes.size()))) {
    const Board board =
        grid_board({1, 1, 1.0, 0.3, id}, spec.family, spec.border_bits, spec.corner_squares);
    scene.boards.push_back({board, Pose()});
    scene.sensor = {1, spec.blur_px, spec.noise_levels};
    scene.paper_level = 220 / 255.0;
    scene.ink_level = 30 / 255.0;
    scene.paper_margin_m = 2;
  }

  std::optional<std::array<Eigen::Vector2d, 4>> corners(const Pose& camera_from_world) const {
    std::array<Eigen::Vector2d, 4> result;
    const auto corners = tag_corners(scene.boards[0].board.tags[0]);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto pixel = project(scene.camera.lens, camera_from_world * corners[i]);
      if (!pixel) return std::nullopt;
      result[i] = *pixel;
    }
    return result;
  }

  TagView view(const Pose& camera_from_world, Random& random) {
    TagView view{id, corners(camera_from_world).value(), {}, {}, scene.camera};
    const ImageF light = render_light(scene, families, camera_from_world);
    view.image = expose(light, scene.sensor, random.next());
    Sensor quiet = scene.sensor;
    quiet.noise_levels = 0;
    view.noiseless = expose(light, quiet, 0);
    return view;
  }
};

// The tag's middle `distance` along a direction, tilted against it about a random axis and rolled.
inline Pose tag_pose(const Eigen::Vector3d& direction, double distance, double tilt_deg,
                     const Eigen::Vector2d& azimuth_and_roll) {
  using Eigen::Vector3d;
  const double azimuth = azimuth_and_roll.x();
  const Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
  const Eigen::AngleAxisd tilt(tilt_deg * std::numbers::pi / 180, axis);
  const Eigen::AngleAxisd roll(azimuth_and_roll.y(), Vector3d::UnitZ());
  const Eigen::AngleAxisd facing(std::numbers::pi, Vector3d::UnitX());
  const auto ahead = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction);
  const Eigen::Quaterniond rotation(ahead * tilt * roll * facing);
  return Pose(rotation, distance * direction - rotation * Vector3d(0.5, 0.5, 0));
}

inline Eigen::Vector2d random_turns(Random& random) {
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  return {azimuth, random.uniform(0, 2 * std::numbers::pi)};
}

// A tag seen with the given tilt about a random axis and a random roll, in the middle of the
// picture but for a part of a pixel.
inline TagView rendered_tag(const TagViewSpec& spec, Random& random) {
  constexpr double kFocal = 900;
  TagScene tag(spec, random);
  const int width = static_cast<int>(2.4 * spec.side_px) + 24;
  const double middle = 0.5 * (width - 1);
  tag.scene.camera = {pinhole(kFocal, kFocal, middle + random.uniform(-0.5, 0.5),
                              middle + random.uniform(-0.5, 0.5)),
                      {width, width}};
  const Pose pose = tag_pose(Eigen::Vector3d::UnitZ(), kFocal / spec.side_px, spec.tilt_deg,
                             random_turns(random));
  return tag.view(pose, random);
}

// The part [x0, x0 + width) x [y0, y0 + height) of a camera's picture as a picture of its own.
inline Camera cropped(const Camera& camera, int x0, int y0, const ImageSize& size) {
  Camera result = camera;
  result.image_size = size;
  const auto move = [&](auto lens) {
    auto values = lens.parameters();
    values[2] -= x0;
    values[3] -= y0;
    return Lens(decltype(lens)(values));
  };
  result.lens = std::visit(move, camera.lens);
  return result;
}

// Whether a lens shrinks what is at a pixel, along the radius, to less than 0.4 of what it would be
// across it: where a distortion turns back, and no picture of use is.
inline bool is_near_fold(const Camera& camera, const Eigen::Vector2d& pixel) {
  const auto ray = ray_in_camera(camera.lens, pixel);
  if (!ray) return true;
  Eigen::Matrix<double, 2, 2> by_direction;
  constexpr double kAngle = 1e-4;
  const auto turned = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray->direction);
  for (int i = 0; i < 2; ++i) {
    Eigen::Vector3d aside = Eigen::Vector3d::UnitZ();
    aside[i] = kAngle;
    const auto moved = project(camera.lens, turned * aside);
    if (!moved) return true;
    by_direction.col(i) = (*moved - pixel) / kAngle;
  }
  const Eigen::Vector2d stretch = by_direction.jacobiSvd().singularValues();
  return stretch[1] < 0.4 * stretch[0];
}

// A tag anywhere in a camera's picture, all corners at least 3 px within it and the paper around
// the tag in the lens' domain; the sides have side_px as their mean. The view is the part about the
// tag, as far as the picture reaches.
inline TagView tag_through_lens(const TagViewSpec& spec, const Camera& camera, Random& random) {
  using Eigen::Vector2d;
  using Eigen::Vector3d;
  const Vector2d last(camera.image_size.width - 1, camera.image_size.height - 1);
  TagScene tag(spec, random);
  tag.scene.camera = camera;
  for (;;) {
    const Vector2d pixel(random.uniform(0, last.x()), random.uniform(0, last.y()));
    const Vector2d turns = random_turns(random);
    const auto ray = ray_in_camera(camera.lens, pixel);
    if (!ray) continue;
    double distance = 900 / spec.side_px;
    std::optional<std::array<Vector2d, 4>> corners;
    Eigen::AlignedBox2d box;
    Pose pose;
    for (int i = 0; i < 5; ++i) {
      pose = tag_pose(ray->direction, distance, spec.tilt_deg, turns);
      corners = tag.corners(pose);
      if (!corners) break;
      box.setEmpty();
      double sum = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        sum += ((*corners)[k] - (*corners)[(k + 1) % 4]).norm();
        box.extend((*corners)[k]);
      }
      distance *= sum / 4 / spec.side_px;
    }
    if (!corners || (box.min().array() < 3).any() || ((last - box.max()).array() < 3).any())
      continue;
    bool paper_seen = true;
    for (const Vector2d& corner : *corners)
      paper_seen = paper_seen && !is_near_fold(camera, corner);
    for (const double u : {-0.35, 0.5, 1.35})
      for (const double v : {-0.35, 0.5, 1.35})
        paper_seen = paper_seen && in_domain(camera.lens, pose * Vector3d(u, v, 0));
    if (!paper_seen) continue;
    const double beyond = 0.5 * spec.side_px + 12;
    const Vector2d low = (box.min().array() - beyond).max(0.0).floor();
    const Vector2d high = (box.max().array() + beyond).min(last.array()).ceil();
    tag.scene.camera = cropped(
        camera, static_cast<int>(low.x()), static_cast<int>(low.y()),
        {static_cast<int>(high.x() - low.x()) + 1, static_cast<int>(high.y() - low.y()) + 1});
    return tag.view(pose, random);
  }
}

}  // namespace tagcal
