#pragma once

// Pictures of checkerboards by the library's own renderer, with their true corners.

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
  double square_px = 20;  // on the axis, before the tilt
  double tilt_deg = 30;
  double blur_px = 0.8;
  double noise_levels = 2;
  double roll_rad = 0.2;
};

struct CheckerView {
  Camera camera;
  Board board;
  Image8 image;
  Image8 quiet;                                 // with noise of half a level
  std::map<CornerId, Eigen::Vector2d> corners;  // those in the picture
  double least_px = 0;                          // between corners
  // True if all corners are seen, and the squares about them.
  bool is_whole = false;
};

// A board before a camera, black 30, white 220, tilted to a random side.
inline CheckerView checker_view(const Board& board, const Camera& camera,
                                const CheckerViewSpec& spec, Random& random) {
  CheckerView view{camera, board, {}, {}, {}, std::numeric_limits<double>::max(), true};
  const Checkerboard squares = checkers(board).value();
  Scene scene;
  scene.camera = camera;
  scene.sensor.blur_px = spec.blur_px;
  scene.paper_level = 220 / 255.0;
  scene.ink_level = 30 / 255.0;
  scene.sensor.noise_levels = spec.noise_levels;
  scene.boards = {{board, Pose()}};
  const double side = squares.column_spacing;
  const Eigen::Vector3d centre(side * (squares.columns - 1) / 2, side * (squares.rows - 1) / 2, 0);
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
  for (int row = -1; row <= squares.rows; ++row) {
    for (int column = -1; column <= squares.columns; ++column) {
      const auto pixel = project(camera.lens, pose * Eigen::Vector3d(column * side, row * side, 0));
      const bool is_seen = pixel && pixel->x() > 2 && pixel->y() > 2 &&
                           pixel->x() < camera.image_size.width - 3 &&
                           pixel->y() < camera.image_size.height - 3;
      view.is_whole = view.is_whole && is_seen;
      if (!is_seen || column < 0 || row < 0 || column == squares.columns || row == squares.rows)
        continue;
      for (const auto& [id, other] : view.corners)
        view.least_px = std::min(view.least_px, (other - *pixel).norm());
      view.corners[{squares.first_id + row * squares.columns + column, 0}] = *pixel;
    }
  }
  const ImageF light = render_light(scene, tag_families(scene.boards), pose);
  view.image = expose(light, scene.sensor, random.next());
  scene.sensor.noise_levels = 0.5;
  view.quiet = expose(light, scene.sensor, random.next());
  return view;
}

}  // namespace tagcal
