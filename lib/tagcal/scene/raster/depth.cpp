#include "tagcal/scene/raster/depth.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "tagcal/scene/raster/tracer.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A sheet for rays.
struct Target {
  Vector3d normal;
  double offset;                  // normal . x
  std::vector<HalfSpace> inside;  // of its edges
  Eigen::AlignedBox2d image;      // in pixels

  // The distance along the ray; infinite if it does not meet the sheet.
  double distance(const Ray& ray, double nearest) const {
    const double along = (offset - normal.dot(ray.origin)) / normal.dot(ray.direction);
    const bool meets = along > nearest && contains(inside, ray.origin + along * ray.direction);
    return meets ? along : std::numeric_limits<double>::infinity();
  }
};

Eigen::AlignedBox2d image_of(const Sheet& sheet, const Tracer& tracer) {
  Outlines outlines;
  for (const std::vector<Vector3d>& part : tracer.in_domain(sheet.corners))
    tracer.trace(part, outlines);
  Eigen::AlignedBox2d box;
  for (const Outlines::Edge& edge : outlines.edges())
    box.extend(edge.from - Vector2d(0.5, 0.5)).extend(edge.to - Vector2d(0.5, 0.5));
  // The chords of an edge lie within less than this of the edge.
  if (!box.isEmpty()) box = {box.min() - Vector2d(1, 1), box.max() + Vector2d(1, 1)};
  return box;
}

// A sheet that is seen edge-on is not seen.
std::vector<Target> targets(const Shadows& shadows, std::span<const std::size_t> sheets,
                            const Camera& camera) {
  const Tracer tracer(camera, 1);
  std::vector<Target> result;
  for (const std::size_t i : sheets) {
    if (shadows.shadow(i, Shadows::kNone).empty()) continue;
    const Sheet& sheet = shadows.sheets()[i];
    const std::size_t n = sheet.corners.size();
    Target target{sheet.normal, sheet.normal.dot(sheet.corners[0]), {}, image_of(sheet, tracer)};
    for (std::size_t k = 0; k < n; ++k) {
      const Vector3d inside = sheet.normal.cross(sheet.corners[(k + 1) % n] - sheet.corners[k]);
      target.inside.push_back({inside, inside.dot(sheet.corners[k])});
    }
    result.push_back(std::move(target));
  }
  return result;
}

}  // namespace

ImageF depth_of_sheets(const Shadows& shadows, std::span<const std::size_t> sheets,
                       const Camera& camera) {
  const std::vector<Target> all = targets(shadows, sheets, camera);
  // Parallel rays come from infinitely far behind the plane in which they are said to start.
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double start = kind_of(camera.lens).is_central ? 0 : -kInfinity;
  ImageF depth(camera.image_size, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const Vector2d pixel(x, y);
      std::optional<Ray> ray;
      double nearest = kInfinity;
      for (const Target& target : all) {
        if (!target.image.contains(pixel)) continue;
        if (!ray) ray = ray_in_camera(camera.lens, pixel);
        if (!ray) break;
        nearest = std::min(nearest, target.distance(*ray, start));
      }
      if (nearest < kInfinity)
        depth(x, y) = static_cast<float>(ray->origin.z() + nearest * ray->direction.z());
    }
  return depth;
}

}  // namespace tagcal::internal
