#pragma once

// Random scenes of flat sheets that cut, touch and hide each other: rays against the renderer and
// the exact corners.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "ray_caster.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal::sheet_rays {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Counts {
  long pixels = 0;
  long wrong_pixels = 0;
  long points = 0;  // corners of tags and points in space, with what hides them
  long wrong_points = 0;
  long cut_scenes = 0;  // with two sheets that cut each other
};

inline double uniform(Random& random, double half) { return random.uniform(-half, half); }
inline Vector3d in_cube(Random& random, double half) {
  const double x = uniform(random, half), y = uniform(random, half);
  return {x, y, uniform(random, half)};
}
inline Pose any_pose(Random& random, double half) {
  const Vector3d at = in_cube(random, half);
  return Pose(exp_rotation(in_cube(random, 2.5)), at);
}

// Three to six corners on an ellipse.
inline std::vector<Vector3d> convex_polygon(Random& random, const Pose& world_from_sheet) {
  const int count = 3 + static_cast<int>(random.uniform(0, 4));
  const double a = random.uniform(0.1, 1), b = random.uniform(0.1, 1);
  std::vector<Vector3d> corners;
  for (int i = 0; i < count; ++i) {
    const double turn = 2 * std::numbers::pi * (i + random.uniform(0, 0.7)) / count;
    corners.push_back(world_from_sheet * Vector3d(a * std::cos(turn), b * std::sin(turn), 0));
  }
  return corners;
}

inline Pose frame_of(const std::vector<Vector3d>& corners) {
  const Vector3d x = (corners[1] - corners[0]).normalized();
  const Vector3d z = x.cross(corners[2] - corners[0]).normalized();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return Pose(Eigen::Quaterniond(axes), corners[0]);
}

// Anywhere; or in the plane of an earlier occluder; or with an edge of it in common, as a box has.
inline std::vector<Vector3d> random_sheet(Random& random, const std::vector<Occluder>& earlier) {
  const double kind = random.uniform();
  if (earlier.empty() || kind < 0.7) return convex_polygon(random, any_pose(random, 0.7));
  const std::vector<Vector3d>& other = earlier.back().corners;
  const Pose plane = frame_of(other);
  if (kind < 0.85) {
    const Vector3d shift(uniform(random, 0.6), uniform(random, 0.6), 0);
    return convex_polygon(random, plane * Pose(Eigen::Quaterniond::Identity(), shift));
  }
  const Vector3d along = other[1] - other[0];
  const Vector3d aside = plane.rotation() * exp_rotation({uniform(random, 3), 0, 0}) *
                         Vector3d(0, random.uniform(0.1, 1), 0);
  return {other[0], other[0] + along, other[1] + aside, other[0] + aside};
}

// A rectangle of whole steps along the axes, as walls, boxes and floors have them: sheets touch,
// lie in one plane or are seen edge-on, and edges lie in planes of others.
constexpr double kStep = 0.25;

inline Vector3d on_grid(const Vector3d& x) { return kStep * (x / kStep).array().round(); }

inline std::vector<Vector3d> grid_sheet(Random& random) {
  const Vector3d corner = on_grid(in_cube(random, 0.8));
  const auto axis = static_cast<int>(random.index(3));
  const Vector3d u = kStep * static_cast<double>(1 + random.index(4)) * Vector3d::Unit(axis);
  const Vector3d v =
      kStep * static_cast<double>(1 + random.index(4)) * Vector3d::Unit((axis + 1) % 3);
  return {corner, corner + u, corner + u + v, corner + v};
}

// Three bars, each of which is before one and behind the other.
inline void add_ring(std::vector<Occluder>& occluders, const Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    const Pose bar = pose * Pose(exp_rotation({0, 0, 2 * std::numbers::pi * i / 3}), {0, 0, 0}) *
                     Pose(exp_rotation({0, 0.3, 0}), {0, -0.25, 0});
    Occluder occluder;
    for (const auto& [x, y] : {std::pair(-0.8, -0.1), {0.8, -0.1}, {0.8, 0.1}, {-0.8, 0.1}})
      occluder.corners.push_back(bar * Vector3d(x, y, 0));
    occluders.push_back(occluder);
  }
}

inline Lens random_lens(Random& random, const ImageSize& size) {
  const double cx = (size.width - 1) / 2.0, cy = (size.height - 1) / 2.0;
  const double kind = random.uniform();
  if (kind < 0.4) {
    const double f = random.uniform(60, 200);
    if (kind < 0.2) return pinhole(f, f, cx, cy);
    return Perspective({f, f, cx, cy, random.uniform(-0.15, 0.1)});
  }
  if (kind < 0.75) {  // up to 280 degrees over the width
    const double f = size.width / random.uniform(2, 4.9);
    return Fisheye({f, f, cx, cy, 0, 0, 0, 0});
  }
  const double scale = random.uniform(30, 90);
  return Parallel({scale, scale, cx, cy});
}

// Tags without a picture (ink as the paper), so that a sheet has one level.
inline Scene random_scene(std::uint64_t seed, std::uint64_t index, Pose& camera_from_world) {
  Random random(seed, index);
  Scene scene;
  const ImageSize size{160, 120};
  scene.camera = {random_lens(random, size), size};
  scene.background_level = 0.5;
  scene.paper_level = scene.ink_level = 0.97;
  const auto count = 2 + static_cast<std::size_t>(random.uniform(0, 11));
  const auto num_boards =
      std::min<std::size_t>(count, static_cast<std::size_t>(random.uniform(0, 4)));
  if (count - num_boards >= 3 && random.uniform() < 0.2)
    add_ring(scene.occluders, any_pose(random, 0.5));
  const bool grid_scene = random.uniform() < 0.2;
  while (scene.occluders.size() + num_boards < count)
    scene.occluders.push_back(
        {grid_scene ? grid_sheet(random) : random_sheet(random, scene.occluders)});
  for (std::size_t i = 0; i < scene.occluders.size(); ++i)
    scene.occluders[i].level = (i % 2 == 0 ? 0.02 : 0.55) + 0.03 * static_cast<double>(i / 2);
  for (std::size_t i = 0; i < num_boards; ++i) {
    Pose pose = any_pose(random, 0.7);
    const bool on_a_desk = !scene.occluders.empty() && random.uniform() < 0.3;
    if (on_a_desk)  // no corner of it exactly on a border of another sheet
      pose = frame_of(scene.occluders.back().corners) *
             Pose(Eigen::Quaterniond::Identity(), {0.0137, 0.0219, 0});
    const AprilGrid grid{1,
                         1 + static_cast<int>(i),
                         random.uniform(0.1, 0.5),
                         0.3,
                         static_cast<int>(10 * i),
                         "tag36h11",
                         1,
                         false};
    scene.boards.push_back({make_board(grid), pose});
  }
  const Vector3d anywhere = in_cube(random, 1).normalized() * random.uniform(0, 3);
  const Vector3d eye = grid_scene ? on_grid(anywhere) : anywhere;
  camera_from_world = rotation_about_z(random.uniform(-3, 3)) *
                      camera_from_world_looking_at(eye, in_cube(random, 0.3), Vector3d::UnitZ());
  return scene;
}

inline void compare_pixels(const Scene& scene, const ImageF& light, const RayCaster& rays,
                           Counts& counts) {
  constexpr double kLevel = 1e-3;  // levels of two surfaces differ by 0.03 or more
  BorderPixels borders_of(rays, light.size());
  bool cut = false;
  for (const Segment& border : borders(rays.surfaces(), &cut)) borders_of.add(border);
  counts.cut_scenes += cut ? 1 : 0;
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      if (borders_of.near(x, y)) continue;
      // Beyond the lens there is nothing, and its border is one of all surfaces.
      std::array<std::optional<Ray>, 5> around;
      for (std::size_t i = 0; i < 5; ++i)
        around[i] =
            rays.ray({x + std::array{0, -2, 2, -2, 2}[i], y + std::array{0, -2, -2, 2, 2}[i]});
      if (std::ranges::any_of(around, [](const auto& ray) { return !ray; })) continue;
      const Surface* seen = rays.first(*around[0]);
      const double level = seen != nullptr ? seen->level : scene.background_level;
      ++counts.pixels;
      if (!(std::abs(static_cast<double>(light(x, y)) - level) < kLevel)) ++counts.wrong_pixels;
    }
}

inline void compare_corners(const Scene& scene, const Pose& pose, const RayCaster& rays,
                            Counts& counts) {
  std::vector<CornerId> expected;
  for (std::size_t i = 0; i < scene.boards.size(); ++i) {
    const Surface& paper = rays.surfaces()[scene.occluders.size() + i];
    for (const TargetPoint& point : target_points(scene.boards[i].board)) {
      const Vector3d x = scene.boards[i].world_from_board * point.position;
      const auto pixel = rays.pixel(x);
      if (pixel && contains(scene.camera.image_size, *pixel) && rays.faces(paper) &&
          rays.instead(x, &paper) == nullptr)
        expected.push_back(point.id);
      ++counts.points;
    }
  }
  std::ranges::sort(expected);
  std::vector<CornerId> seen, wrong;
  for (const Observation& o : visible_corners(scene, pose)) seen.push_back(o.id);
  std::ranges::set_symmetric_difference(seen, expected, std::back_inserter(wrong));
  counts.wrong_points += static_cast<long>(wrong.size());
}

// Points in space, and what `followed` says hides them.
inline void compare_points(const Scene& scene, const Pose& pose, const RayCaster& rays,
                           Random& random, Counts& counts) {
  const NearFar planes = enclosing_planes(scene, pose);
  const ViewingPipeline pipeline =
      viewing_pipeline(scene.camera, pose, planes.near_m, planes.far_m);
  for (int i = 0; i < 20; ++i) {
    const Vector3d x = in_cube(random, 1.5);
    const FollowedPoint f = followed({"x", {}, x, {}}, scene, pipeline);
    if (!f.pixel || !contains(scene.camera.image_size, *f.pixel)) continue;
    const Surface* hider = rays.instead(x, nullptr);
    ++counts.points;
    if (f.hidden_by != (hider != nullptr ? hider->name : "") ||
        (f.sight == Sight::hidden) != (hider != nullptr))
      ++counts.wrong_points;
  }
}

inline void compare(std::uint64_t seed, std::uint64_t index, const TagFamilies& families,
                    Counts& counts) {
  Pose pose;
  const Scene scene = random_scene(seed, index, pose);
  const RayCaster rays(scene, pose);
  compare_pixels(scene, render_light(scene, families, pose), rays, counts);
  compare_corners(scene, pose, rays, counts);
  Random random(seed + 1, index);
  compare_points(scene, pose, rays, random, counts);
}

}  // namespace tagcal::sheet_rays
