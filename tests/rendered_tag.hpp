#pragma once

// Pictures of single plain tags by the library's own renderer, with their true corners.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
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
};

// A tag on white, black 30, white 220, seen with the given tilt about a random axis and a
// random roll, in the middle of the picture but for a part of a pixel.
inline TagView rendered_tag(const TagViewSpec& spec, Random& random) {
  constexpr double kFocal = 900;
  const TagFamilies families = {{spec.family, tag_family(spec.family, 1)}};
  TagView view;
  view.id = static_cast<int>(random.index(families.at(spec.family).codes.size()));
  Scene scene;
  const Board board =
      grid_board({1, 1, 1.0, 0.3, view.id}, spec.family, spec.border_bits, spec.corner_squares);
  scene.boards.push_back({board, Pose()});
  const int width = static_cast<int>(2.4 * spec.side_px) + 24;
  const double middle = 0.5 * (width - 1);
  scene.camera = {pinhole(kFocal, kFocal, middle + random.uniform(-0.5, 0.5),
                          middle + random.uniform(-0.5, 0.5)),
                  {width, width}};
  scene.sensor = {1, spec.blur_px, spec.noise_levels};
  scene.paper_level = 220 / 255.0;
  scene.ink_level = 30 / 255.0;
  scene.paper_margin_m = 2;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
  const Eigen::AngleAxisd tilt(spec.tilt_deg * std::numbers::pi / 180, axis);
  const Eigen::AngleAxisd roll(random.uniform(0, 2 * std::numbers::pi), Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd facing(std::numbers::pi, Eigen::Vector3d::UnitX());
  const Eigen::Quaterniond rotation(tilt * roll * facing);
  const Eigen::Vector3d ahead(0, 0, kFocal / spec.side_px);
  const Pose camera_from_world(rotation, ahead - rotation * Eigen::Vector3d(0.5, 0.5, 0));
  const auto corners = tag_corners(board.tags[0]);
  for (std::size_t i = 0; i < 4; ++i)
    view.corners[i] = project(scene.camera.lens, camera_from_world * corners[i]).value();
  const ImageF light = render_light(scene, families, camera_from_world);
  view.image = expose(light, scene.sensor, random.next());
  scene.sensor.noise_levels = 0;
  view.noiseless = expose(light, scene.sensor, 0);
  return view;
}

}  // namespace tagcal
