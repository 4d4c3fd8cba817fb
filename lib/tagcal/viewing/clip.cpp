#include "tagcal/viewing/clip.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tagcal {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using Polygon = std::vector<Vector3d>;

constexpr int kConePlanes = 256;

// Cuts stay this far (radians) inside a lens' domain, so that rounding leaves nothing outside. The
// backward direction, in which all directions of the image meet, is excluded by the same angle.
constexpr double kOffDomainBorder = 1e-9;
constexpr double kOffBackwardAxis = 1e-6;

// Polygons that come closer (radians) to the backward axis are divided into sectors.
constexpr double kCloseToBackwardAxis = 0.3;

// Sutherland and Hodgman's step for any type of point; `height` is >= 0 on the kept side.
template <typename Point, typename Height>
std::vector<Point> kept_part(const std::vector<Point>& polygon, const Height& height) {
  std::vector<Point> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& a = polygon[i];
    const Point& b = polygon[(i + 1) % polygon.size()];
    const double height_a = height(a), height_b = height(b);
    if (height_a >= 0) result.push_back(a);
    if ((height_a >= 0) == (height_b >= 0)) continue;
    // Interpolates from the kept end, so that both polygons of a shared edge get the same point.
    result.push_back(height_a >= 0 ? Point(a + height_a / (height_a - height_b) * (b - a))
                                   : Point(b + height_b / (height_b - height_a) * (a - b)));
  }
  if (result.size() < 3) result.clear();
  return result;
}

Vector3d at_turn(double turn) { return {std::cos(turn), std::sin(turn), 0}; }

// The plane i of kConePlanes through the apex that touches the cone of the given half-angle (below
// 90 degrees) about +-z, its inside kept.
HalfSpace cone_plane(int i, double half_angle, double axis_sign) {
  const Vector3d outward = at_turn(2 * std::numbers::pi * (i + 0.5) / kConePlanes);
  return {axis_sign * std::sin(half_angle) * Vector3d::UnitZ() - std::cos(half_angle) * outward, 0};
}

Polygon clip_to_cone(Polygon polygon, double half_angle, double axis_sign) {
  for (int i = 0; i < kConePlanes && !polygon.empty(); ++i)
    polygon = clip_polygon(polygon, cone_plane(i, half_angle, axis_sign));
  return polygon;
}

// A pyramid inside the cone about +z of the given half-angle.
Polygon within_cone(const Polygon& polygon, double half_angle) {
  const double inscribed =
      std::atan(std::tan(half_angle - kOffDomainBorder) * std::cos(std::numbers::pi / kConePlanes));
  return clip_to_cone(polygon, inscribed, 1);
}

// A half-space whose plane contains the z axis, at an angle; neighbouring sectors share the plane
// exactly.
HalfSpace sector_side(int i, double sign) {
  const Vector3d along = at_turn(2 * std::numbers::pi * (i % kConePlanes) / kConePlanes);
  return {sign * Vector3d(-along.y(), along.x(), 0), 0};
}

// Removes from a convex polygon its part inside the pyramid around the cone about -z of the given
// half-angle, and divides the rest into sectors about the axis: an edge that passes close to the
// axis turns by at most one sector within a part.
std::vector<Polygon> without_backward_cone(const Polygon& polygon, double half_angle) {
  const double cut = std::max(half_angle + kOffDomainBorder, kOffBackwardAxis);
  const double close = std::min(cut + kCloseToBackwardAxis, std::numbers::pi / 2);
  if (clip_to_cone(polygon, close, -1).empty()) return {polygon};
  std::vector<Polygon> parts;
  for (int i = 0; i < kConePlanes; ++i) {
    const HalfSpace inside = cone_plane(i, cut, -1);
    const std::array<HalfSpace, 3> planes = {
        sector_side(i, 1), sector_side(i + 1, -1), {-inside.normal, -inside.offset}};
    Polygon part = clip_polygon(polygon, planes);
    if (!part.empty()) parts.push_back(std::move(part));
  }
  return parts;
}

bool all_inside(const Polygon& polygon, const Lens& lens) {
  return std::ranges::all_of(polygon, [&](const Vector3d& x) { return in_domain(lens, x); });
}

}  // namespace

std::vector<HalfSpace> clip_planes(const Eigen::Matrix4d& m) {
  const Eigen::RowVector4d w = m.row(3);
  const Eigen::RowVector4d rows[] = {w + m.row(0), w - m.row(0), w + m.row(1),
                                     w - m.row(1), w + m.row(2), w - m.row(2)};
  std::vector<HalfSpace> planes;
  for (const Eigen::RowVector4d& row : rows) {
    const double length = row.head<3>().norm();
    if (length > 0) planes.push_back({row.head<3>() / length, -row[3] / length});
  }
  return planes;
}

bool contains(std::span<const HalfSpace> planes, const Vector3d& x) {
  return std::ranges::all_of(planes, [&](const HalfSpace& p) { return p.height(x) >= 0; });
}

bool in_clip_volume(const Vector4d& x_in_clip) {
  return (x_in_clip.head<3>().array().abs() <= x_in_clip.w()).all();
}

std::optional<Vector3d> segment_plane_intersection(const Vector3d& a, const Vector3d& b,
                                                   const HalfSpace& plane) {
  const double height_a = plane.height(a), height_b = plane.height(b);
  if (height_a == height_b) return std::nullopt;
  const double share = height_a / (height_a - height_b);
  if (!(share >= 0 && share <= 1)) return std::nullopt;
  return Vector3d((1 - share) * a + share * b);
}

std::optional<SegmentPart> clip_segment(const Vector3d& a, const Vector3d& b,
                                        std::span<const HalfSpace> planes) {
  if (!a.allFinite() || !b.allFinite()) return std::nullopt;
  SegmentPart part;
  for (const HalfSpace& plane : planes) {
    const double height = plane.height(a), climb = plane.normal.dot(b - a);
    if (climb == 0 && height < 0) return std::nullopt;
    if (climb > 0) part.from = std::max(part.from, -height / climb);
    if (climb < 0) part.to = std::min(part.to, -height / climb);
  }
  if (part.from > part.to) return std::nullopt;
  return part;
}

Polygon clip_polygon(const Polygon& polygon, const HalfSpace& kept) {
  return kept_part(polygon, [&](const Vector3d& x) { return kept.height(x); });
}

Polygon clip_polygon(const Polygon& polygon, std::span<const HalfSpace> planes) {
  Polygon result = polygon;
  for (std::size_t i = 0; i < planes.size() && !result.empty(); ++i)
    result = clip_polygon(result, planes[i]);
  return result;
}

std::vector<Vector4d> clip_polygon_to_volume(const std::vector<Vector4d>& polygon) {
  std::vector<Vector4d> result = polygon;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0})
      result = kept_part(result, [&](const Vector4d& x) { return x.w() + sign * x[axis]; });
  return result;
}

bool is_back_face(std::span<const Vector3d> corners, const Vector3d& eye) {
  const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  return !(normal.dot(eye - corners[0]) > 0);
}

std::vector<Polygon> clip_to_domain(const Polygon& polygon, const Lens& lens, double near_m) {
  std::vector<Polygon> parts = {polygon};
  const LensKind& kind = kind_of(lens);
  if (kind.is_central && !kind.reaches_behind) {
    parts = {clip_polygon(polygon, {Vector3d::UnitZ(), near_m})};
    if (!all_inside(parts[0], lens)) parts = {within_cone(parts[0], max_angle(lens))};
  } else if (kind.is_central) {
    const double angle = max_angle(lens);
    if (angle >= std::numbers::pi / 2)
      parts = without_backward_cone(polygon, std::numbers::pi - angle);
    else if (!all_inside(polygon, lens))
      parts = {within_cone(polygon, angle)};
  }
  std::erase_if(parts, [&](const Polygon& p) { return p.empty() || !all_inside(p, lens); });
  return parts;
}

}  // namespace tagcal
