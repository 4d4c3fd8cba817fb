#include "tagcal/camera/clip.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tagcal {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr int kConePlanes = 256;

bool all_inside(const Polygon& polygon, const Lens& lens) {
  return std::ranges::all_of(polygon, [&](const Vector3d& x) { return in_domain(lens, x); });
}

// Within the cone about +z of the given tangent.
Polygon clip_to_cone(Polygon polygon, double tangent) {
  const double inscribed = tangent * std::cos(std::numbers::pi / kConePlanes);
  for (int i = 0; i < kConePlanes && !polygon.empty(); ++i) {
    const double turn = 2 * std::numbers::pi * i / kConePlanes;
    polygon = clip_polygon(polygon, {Vector3d(-std::cos(turn), -std::sin(turn), inscribed), 0});
  }
  return polygon;
}

}  // namespace

Polygon clip_polygon(const Polygon& polygon, const HalfSpace& kept) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& a = polygon[i];
    const Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double height_a = kept.normal.dot(a) - kept.offset;
    const double height_b = kept.normal.dot(b) - kept.offset;
    if (height_a >= 0) result.push_back(a);
    if ((height_a >= 0) == (height_b >= 0)) continue;
    // From the kept end, so that both polygons of a shared edge get the same point.
    result.push_back(height_a >= 0 ? Vector3d(a + height_a / (height_a - height_b) * (b - a))
                                   : Vector3d(b + height_b / (height_b - height_a) * (a - b)));
  }
  if (result.size() < 3) result.clear();
  return result;
}

Polygon clip_to_domain(const Polygon& polygon, const Lens& lens, double near_m) {
  Polygon result = polygon;
  double tangent = 0;  // of the convex cone, 0: none
  if (const auto* perspective = std::get_if<Perspective>(&lens)) {
    result = clip_polygon(polygon, {Vector3d::UnitZ(), near_m});
    if (std::isfinite(perspective->max_radius())) tangent = perspective->max_radius();
  } else if (const auto* fisheye = std::get_if<Fisheye>(&lens)) {
    if (fisheye->max_angle() < std::numbers::pi / 2) tangent = std::tan(fisheye->max_angle());
  }
  if (all_inside(result, lens)) return result;
  if (tangent == 0) return {};
  result = clip_to_cone(result, tangent * (1 - 1e-9));
  return all_inside(result, lens) ? result : Polygon();
}

}  // namespace tagcal
