#pragma once

// Pictures of checkerboards and grids of circles by the library's own renderer, with their true
// corners or centres.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "tagcal/detect/families.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {

struct CheckerViewSpec {
  double square_px = 20;  // or between two centres; on the axis, before the tilt
  double tilt_deg = 30;
  double blur_px = 0.8;
  double noise_levels = 2;
  double roll_rad = 0.2;
};

struct CheckerView {
  Camera camera;
  Board board;
  Image8 image;
  std::map<CornerId, Eigen::Vector2d> corners;  // those in the picture
  double least_px = 0;                          // between corners
  // True if all corners are seen, and what is printed about them.
  bool is_whole = false;
};

// A side of a square, or the distance of the nearest two centres.
inline double step_m(const Board& board) {
  const auto* const circles = std::get_if<CircleGrid>(&board.pattern);
  return circles ? centre_distance(*circles) : checkers(board).value().column_spacing;
}

// A board before a camera, black 30, white 220, tilted to a random side.
inline CheckerView checker_view(const Board& board, const Camera& camera,
                                const CheckerViewSpec& spec, Random& random) {
  CheckerView view{camera, board, {}, {}, std::numeric_limits<double>::max(), true};
  const std::vector<TargetPoint> points = target_points(board);
  Scene scene;
  scene.camera = camera;
  scene.sensor.blur_px = spec.blur_px;
  scene.paper_level = 220 / 255.0;
  scene.ink_level = 30 / 255.0;
  scene.sensor.noise_levels = spec.noise_levels;
  scene.boards = {{board, Pose()}};
  const double side = step_m(board);
  const Eigen::Vector3d centre = (points.front().position + points.back().position) / 2;
  const Eigen::Vector2d middle(camera.image_size.width / 2.0, camera.image_size.height / 2.0);
  const auto ray = ray_in_camera(camera.lens, middle);
  const auto next = ray_in_camera(camera.lens, middle + Eigen::Vector2d(1, 0));
  const double rad_per_px = (next->direction.normalized() - ray->direction.normalized()).norm();
  const double distance = side / (rad_per_px * spec.square_px);
  const double tilt = spec.tilt_deg * std::numbers::pi / 180;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d from(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                             std::cos(tilt));
  const Eigen::Vector3d aside =
      rad_per_px * distance * Eigen::Vector3d(random.uniform(-9, 9), random.uniform(-9, 9), 0);
  const Pose pose = camera_from_world_looking_at(
      centre + distance * from, centre + aside,
      Eigen::Vector3d(std::sin(spec.roll_rad), std::cos(spec.roll_rad), 0.01));
  const auto seen = [&](const Eigen::Vector3d& place) -> std::optional<Eigen::Vector2d> {
    const auto pixel = project(camera.lens, pose * place);
    const bool is_seen = pixel && pixel->x() > 2 && pixel->y() > 2 &&
                         pixel->x() < camera.image_size.width - 3 &&
                         pixel->y() < camera.image_size.height - 3;
    return is_seen ? pixel : std::nullopt;
  };
  for (const TargetPoint& point : points) {
    for (const double x : {-side, side})
      for (const double y : {-side, side})
        view.is_whole = view.is_whole && seen(point.position + Eigen::Vector3d(x, y, 0));
    const auto pixel = seen(point.position);
    if (!pixel) continue;
    for (const auto& [id, other] : view.corners)
      view.least_px = std::min(view.least_px, (other - *pixel).norm());
    view.corners[point.id] = *pixel;
  }
  const ImageF light = render_light(scene, tag_families(scene.boards), pose);
  view.image = expose(light, scene.sensor, random.next());
  return view;
}

}  // namespace tagcal
