#pragma once

// Random scenes of flat sheets that cut, touch and hide each other, and rays against the renderer
// and the exact corners. Nothing here uses the library's visibility: a ray is cut with one sheet
// after the other, and the nearest hit counts.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

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

// A sheet of a scene as the rays see it.
struct Surface {
  std::vector<Vector3d> corners;
  Vector3d normal;
  double level = 0;
  std::string name;
  bool paper = false;
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
    if (on_a_desk) pose = frame_of(scene.occluders.back().corners);
    const Grid grid{1, 1 + static_cast<int>(i), random.uniform(0.1, 0.5), 0.3,
                    static_cast<int>(10 * i)};
    scene.boards.push_back({grid_board(grid, "tag36h11", 1, false), pose});
  }
  const Vector3d anywhere = in_cube(random, 1).normalized() * random.uniform(0, 3);
  const Vector3d eye = grid_scene ? on_grid(anywhere) : anywhere;
  camera_from_world = rotation_about_z(random.uniform(-3, 3)) *
                      camera_from_world_looking_at(eye, in_cube(random, 0.3), Vector3d::UnitZ());
  return scene;
}

// The paper of a board of tags in a row, or in a grid: the tags and the margin around them.
inline std::vector<Surface> surfaces_of(const Scene& scene) {
  std::vector<Surface> result;
  for (std::size_t i = 0; i < scene.occluders.size(); ++i)
    result.push_back({scene.occluders[i].corners,
                      {},
                      scene.occluders[i].level,
                      "occluder " + std::to_string(i),
                      false});
  for (std::size_t i = 0; i < scene.boards.size(); ++i) {
    Eigen::AlignedBox3d box;
    for (const TargetPoint& point : target_points(scene.boards[i].board))
      box.extend(point.position);
    const double m = scene.paper_margin_m;
    const Vector3d low = box.min() - Vector3d(m, m, 0), high = box.max() + Vector3d(m, m, 0);
    Surface paper{{}, {}, scene.paper_level, "board " + std::to_string(i), true};
    for (const Vector3d& corner : {Vector3d(low.x(), low.y(), 0), Vector3d(high.x(), low.y(), 0),
                                   Vector3d(high.x(), high.y(), 0), Vector3d(low.x(), high.y(), 0)})
      paper.corners.push_back(scene.boards[i].world_from_board * corner);
    result.push_back(paper);
  }
  for (Surface& surface : result)
    surface.normal = (surface.corners[1] - surface.corners[0])
                         .cross(surface.corners[2] - surface.corners[0])
                         .normalized();
  return result;
}

// Returns true if a point in the plane of the surface lies in it.
inline bool holds(const Surface& surface, const Vector3d& x) {
  for (std::size_t i = 0; i < surface.corners.size(); ++i) {
    const Vector3d& a = surface.corners[i];
    const Vector3d& b = surface.corners[(i + 1) % surface.corners.size()];
    if ((b - a).cross(x - a).dot(surface.normal) < 0) return false;
  }
  return true;
}

class RayCaster {
 public:
  RayCaster(const Scene& scene, const Pose& camera_from_world)
      : surfaces_(surfaces_of(scene)),
        camera_(scene.camera),
        camera_from_world_(camera_from_world),
        world_from_camera_(camera_from_world.inverse()) {}

  const std::vector<Surface>& surfaces() const { return surfaces_; }

  // A ray in world coordinates through a pixel; from far behind the camera if rays are parallel.
  std::optional<Ray> ray(const Vector2d& pixel) const {
    auto result = ray_in_camera(camera_.lens, pixel);
    if (!result) return std::nullopt;
    if (is_parallel()) result->origin -= 100 * result->direction;
    return Ray{world_from_camera_ * result->origin,
               world_from_camera_.rotation() * result->direction};
  }

  // The surface that a ray hits first, before a distance. Of hits at one distance the upper one
  // counts: papers lie on occluders, else the later one on the earlier.
  const Surface* first(const Ray& ray, double before = 1e9) const {
    const Surface* nearest = nullptr;
    double distance = before;
    for (const Surface& surface : surfaces_) {
      const auto hit = distance_to(surface, ray);
      if (!hit || *hit > distance + (nearest != nullptr ? kSame : -kSame)) continue;
      nearest = &surface;
      distance = *hit;
    }
    return nearest;
  }

  // The surface that is seen instead of a point. What lies in one plane with the point's own
  // surface hides it if it lies above.
  const Surface* instead(const Vector3d& x, const Surface* own) const {
    const Vector3d eye =
        is_parallel() ? Vector3d(x - 100 * (world_from_camera_.rotation() * Vector3d::UnitZ()))
                      : world_from_camera_.translation();
    const double distance = (x - eye).norm();
    const Ray ray{eye, (x - eye) / distance};
    const Surface* seen = first(ray, distance);
    if (seen != nullptr || own == nullptr) return seen;
    seen = first(ray, distance + 2 * kSame);
    return seen == own ? nullptr : seen;
  }

  std::optional<Vector2d> pixel(const Vector3d& x_in_world) const {
    return project(camera_.lens, camera_from_world_ * x_in_world);
  }

  // Returns true if the lens is a perspective and the point is not in front of it.
  bool is_behind(const Vector3d& x_in_world) const {
    return std::holds_alternative<Perspective>(camera_.lens) &&
           !((camera_from_world_ * x_in_world).z() > 0);
  }

  bool faces(const Surface& surface) const {
    const Vector3d axis = world_from_camera_.rotation() * Vector3d::UnitZ();
    return surface.normal.dot(is_parallel()
                                  ? Vector3d(-axis)
                                  : world_from_camera_.translation() - surface.corners[0]) > 0;
  }

 private:
  static constexpr double kSame = 1e-7;  // metres along a ray

  bool is_parallel() const { return std::holds_alternative<Parallel>(camera_.lens); }

  static std::optional<double> distance_to(const Surface& surface, const Ray& ray) {
    const double climb = surface.normal.dot(ray.direction);
    const double height = surface.normal.dot(surface.corners[0] - ray.origin);
    if (std::abs(climb) < 1e-9 || std::abs(height) < 1e-9) return std::nullopt;  // edge-on
    const double distance = height / climb;
    if (!(distance > 0) || !holds(surface, ray.origin + distance * ray.direction))
      return std::nullopt;
    return distance;
  }

  std::vector<Surface> surfaces_;
  Camera camera_;
  Pose camera_from_world_;
  Pose world_from_camera_;
};

// The lines along which two surfaces cut each other, and their edges.
struct Segment {
  Vector3d from;
  Vector3d to;
};

inline std::optional<Segment> common_line(const Surface& a, const Surface& b) {
  std::vector<Vector3d> ends;
  const auto add = [&ends](const Surface& s, const Surface& t) {
    for (std::size_t i = 0; i < s.corners.size(); ++i) {
      const Vector3d& from = s.corners[i];
      const Vector3d& to = s.corners[(i + 1) % s.corners.size()];
      const double h0 = t.normal.dot(from - t.corners[0]), h1 = t.normal.dot(to - t.corners[0]);
      if ((h0 < 0) == (h1 < 0)) continue;
      const Vector3d x = from + h0 / (h0 - h1) * (to - from);
      if (holds(t, x)) ends.push_back(x);
    }
  };
  add(a, b);
  add(b, a);
  if (ends.size() < 2) return std::nullopt;
  std::size_t farthest = 1;
  for (std::size_t i = 1; i < ends.size(); ++i)
    if ((ends[i] - ends[0]).norm() > (ends[farthest] - ends[0]).norm()) farthest = i;
  return Segment{ends[0], ends[farthest]};
}

inline std::vector<Segment> borders(const std::vector<Surface>& surfaces, bool* cut) {
  std::vector<Segment> result;
  for (const Surface& surface : surfaces)
    for (std::size_t i = 0; i < surface.corners.size(); ++i)
      result.push_back({surface.corners[i], surface.corners[(i + 1) % surface.corners.size()]});
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (const auto line = common_line(surfaces[i], surfaces[j])) {
        result.push_back(*line);
        *cut = *cut || (line->to - line->from).norm() > 1e-6;
      }
  return result;
}

// The pixels closer than 1 px to the image of a border that is not hidden.
class BorderPixels {
 public:
  BorderPixels(const RayCaster& rays, const ImageSize& size) : rays_(rays), near_(size) {}

  void add(const Segment& s) { add(s, rays_.pixel(s.from), rays_.pixel(s.to), 18); }
  bool near(int x, int y) const { return near_(x, y) != 0; }

 private:
  using Pixel = std::optional<Vector2d>;

  // Halves the segment until the images of its ends are close.
  void add(const Segment& s, const Pixel& from, const Pixel& to, int depth) {
    if (rays_.is_behind(s.from) && rays_.is_behind(s.to)) return;
    if (from && to && (*from - *to).norm() < 0.4) return mark(s.from, *from);
    if (depth == 0) {
      if (from) mark(s.from, *from);
      return;
    }
    const Vector3d middle = 0.5 * (s.from + s.to);
    const Pixel at = rays_.pixel(middle);
    add({s.from, middle}, from, at, depth - 1);
    add({middle, s.to}, at, to, depth - 1);
  }

  void mark(const Vector3d& x, const Vector2d& pixel) {
    constexpr double kReach = 1.3;  // 1 px from the border itself, not only from its samples
    const Eigen::AlignedBox2d image(
        Vector2d(-kReach, -kReach),
        Vector2d(near_.width() - 1 + kReach, near_.height() - 1 + kReach));
    if (!image.contains(pixel) || is_hidden(x)) return;
    for (int v = std::max(0, static_cast<int>(std::ceil(pixel.y() - kReach)));
         v <= std::min(near_.height() - 1.0, pixel.y() + kReach); ++v)
      for (int u = std::max(0, static_cast<int>(std::ceil(pixel.x() - kReach)));
           u <= std::min(near_.width() - 1.0, pixel.x() + kReach); ++u)
        if ((Vector2d(u, v) - pixel).norm() < kReach) near_(u, v) = 1;
  }

  bool is_hidden(const Vector3d& x) const { return rays_.instead(x, nullptr) != nullptr; }

  const RayCaster& rays_;
  Image8 near_;
};

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
