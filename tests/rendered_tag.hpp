#pragma once

// Pictures of single tags anywhere in a camera's picture, by the library's own renderer, with their
// true corners.

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <optional>

#include "study/tasks/tag_view.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal {
using namespace study;

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

// Returns true if the lens compresses the image at a pixel along the radius to less than 0.4 of the
// scale across it: near the fold of a distortion no picture is useful.
inline bool is_near_fold(const Camera& camera, const Eigen::Vector2d& pixel) {
  const auto ray = ray_in_camera(camera.lens, pixel);
  if (!ray) return true;
  Eigen::Matrix<double, 2, 2> by_direction;
  constexpr double kAngle = 1e-4;
  const auto turned = rotation_between(Eigen::Vector3d::UnitZ(), ray->direction);
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
