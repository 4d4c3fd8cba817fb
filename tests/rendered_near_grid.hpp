#pragma once

// Pictures of AprilGrids close to a fisheye camera, with the true corners of the tags that can be
// read.

#include <string>

#include "rendered_checkerboard.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {

struct NearGridSpec {
  std::string model = "fisheye4";  // or ds, eucm
  double field_deg = 180;          // of view, over the longer side of the picture
  double span_deg = 140;           // between the directions of the board's most distant corners
  int border_bits = 1;             // 2: Kalibr's, with squares between the tags
  double noise_levels = 2;
  ImageSize size{1280, 960};
};

inline Camera near_grid_camera(const NearGridSpec& spec) {
  const bool is_eucm = spec.model == "eucm";
  const LensKind& kind = spec.model == "fisheye4" ? kind_of<Fisheye>()
                         : is_eucm                ? kind_of<ExtendedUnified>()
                                                  : kind_of<DoubleSphere>();
  std::vector<double> numbers = spec.model == "fisheye4"
                                    ? std::vector<double>{1, 1, 0, 0, -.01, .003, -.001, 0}
                                : is_eucm ? std::vector<double>{1, 1, 0, 0, .62, 1.08}
                                          : std::vector<double>{1, 1, 0, 0, -.2, .6};
  const double half = spec.field_deg / 2 * std::numbers::pi / 180;
  const auto edge = project(make_lens(kind, numbers), {std::sin(half), 0, std::cos(half)});
  numbers[0] = spec.size.width / 2.0 / edge.value().x();
  numbers[1] = 0.999 * numbers[0];
  numbers[2] = spec.size.width / 2.0 + 4;
  numbers[3] = spec.size.height / 2.0 - 5;
  return {make_lens(kind, numbers), spec.size};
}

// Angle between the directions of the two points that are most distant from each other as seen.
inline double span_rad(const std::vector<TargetPoint>& points, const Eigen::Vector3d& eye) {
  double least = 1;
  for (const TargetPoint& a : points)
    for (const TargetPoint& b : points)
      least = std::min(least, (a.position - eye).normalized().dot((b.position - eye).normalized()));
  return std::acos(least);
}

struct NearGridView : CheckerView {
  std::map<CornerId, Eigen::Vector2d> others;  // true corners of tags that are cut, or small
};

// The true corners of the tags: those that lie in the picture as a whole, sides and all, at least
// `least_px` long, and the others as far as the lens projects them.
inline void add_corners(NearGridView& view, const Pose& camera_from_board, double least_px) {
  constexpr int kSteps = 8;  // along a side
  const ImageSize& size = view.camera.image_size;
  for (const Tag& tag : tags_of(view.board)) {
    const auto corners = tag_corners(tag);
    std::map<CornerId, Eigen::Vector2d> of_tag;
    bool is_whole = true;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d step = (corners[(i + 1) % 4] - corners[i]) / kSteps;
      for (int k = 0; k < kSteps; ++k) {
        const auto at = project(view.camera.lens, camera_from_board * (corners[i] + k * step));
        is_whole &=
            at && at->minCoeff() > 3 && at->x() < size.width - 4 && at->y() < size.height - 4;
        if (at && k == 0) of_tag[{tag.id, static_cast<int>(i)}] = *at;
      }
    }
    for (int i = 0; i < 4 && is_whole; ++i)
      is_whole = (of_tag[{tag.id, (i + 1) % 4}] - of_tag[{tag.id, i}]).norm() >= least_px;
    (is_whole ? view.corners : view.others).merge(of_tag);
  }
}

// A grid of 6 x 6 tags above a random point near its middle, seen by a camera that is turned to one
// side by up to 40 degrees.
inline NearGridView near_grid_view(const NearGridSpec& spec, Random& random) {
  NearGridView view;
  view.camera = near_grid_camera(spec);
  view.board = make_board(
      AprilGrid{6, 6, 0.088, 0.3, 0, "tag36h11", spec.border_bits, spec.border_bits == 2});
  const std::vector<TargetPoint> points = target_points(view.board);
  const Eigen::Vector3d middle = (points.front().position + points.back().position) / 2;
  Eigen::Vector3d eye =
      middle + Eigen::Vector3d(random.uniform(-.1, .1), random.uniform(-.1, .1), 0);
  double near = 1e-3, far = 10;
  while (far - near > 1e-6) {
    eye.z() = (near + far) / 2;
    (span_rad(points, eye) > spec.span_deg * std::numbers::pi / 180 ? near : far) = eye.z();
  }
  const double aside = eye.z() * std::tan(random.uniform(0, 40) * std::numbers::pi / 180);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi), roll = random.uniform(0, 7);
  const Eigen::Vector3d target(eye.x() + aside * std::cos(azimuth),
                               eye.y() + aside * std::sin(azimuth), 0);
  const Pose pose = camera_from_world_looking_at(
      eye, target, Eigen::Vector3d(std::sin(roll), std::cos(roll), 0.01));
  Scene scene;
  scene.camera = view.camera;
  scene.boards = {{view.board, Pose()}};
  scene.sensor.blur_px = 0.7;
  scene.sensor.noise_levels = spec.noise_levels;
  add_corners(view, pose, 12);
  const ImageF light = render_light(scene, tag_families(scene.boards), pose);
  view.image = expose(light, scene.sensor, random.next());
  return view;
}

}  // namespace tagcal
