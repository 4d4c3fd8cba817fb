#pragma once

// What rays meet first in a scene of flat sheets. Nothing here uses the library's visibility: a ray
// is cut with one sheet after the other, and the nearest hit counts.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal::sheet_rays {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A sheet of a scene as the rays see it.
struct Surface {
  std::vector<Vector3d> corners;
  Vector3d normal;
  double level = 0;
  std::string name;
  bool paper = false;
};

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
    const Vector3d back = -(world_from_camera_.rotation() * Vector3d::UnitZ());
    const Vector3d to_eye = world_from_camera_.translation() - surface.corners[0];
    return surface.normal.dot(is_parallel() ? back : to_eye) > kEdgeOn;
  }

 private:
  static constexpr double kSame = 1e-7;    // metres along a ray
  static constexpr double kEdgeOn = 1e-9;  // metres from the eye to a plane; sine of an angle

  bool is_parallel() const { return std::holds_alternative<Parallel>(camera_.lens); }

  static std::optional<double> distance_to(const Surface& surface, const Ray& ray) {
    const double climb = surface.normal.dot(ray.direction);
    const double height = surface.normal.dot(surface.corners[0] - ray.origin);
    if (std::abs(climb) < kEdgeOn || std::abs(height) < kEdgeOn) return std::nullopt;
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

}  // namespace tagcal::sheet_rays
