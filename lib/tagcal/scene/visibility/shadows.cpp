#include "tagcal/scene/surfaces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tagcal {
namespace {

using Eigen::Vector3d;
using Polygon = Shadows::Polygon;

// Points closer than this share of the scene's size count as one point or as lying in one plane: so
// does an eye in the plane of a sheet, and parallel rays at a smaller angle (radians) to it.
// Rounding of double precision stays a hundred times below it up to 10^5 scene sizes from the
// origin (2^-53 * 10^5 = 1e-11).
constexpr double kTouching = 1e-9;

double scene_size(const std::vector<Sheet>& sheets) {
  double largest = 0;
  for (const Sheet& sheet : sheets)
    for (const Vector3d& corner : sheet.corners)
      largest = std::max(largest, (corner - sheets.front().corners.front()).norm());
  return largest;
}

// Returns true if no point of the polygon is above the plane.
bool is_outside(const Polygon& polygon, const HalfSpace& plane, double tolerance_m) {
  return std::ranges::all_of(polygon,
                             [&](const Vector3d& x) { return plane.height(x) <= tolerance_m; });
}

bool meets(const Polygon& polygon, std::span<const HalfSpace> region, double tolerance_m) {
  for (const HalfSpace& plane : region)
    if (is_outside(polygon, plane, tolerance_m)) return false;
  Polygon common = polygon;
  for (const HalfSpace& plane : region) {
    if (is_outside(common, plane, tolerance_m)) return false;
    common = clip_polygon(common, plane);
  }
  return !region.empty();
}

// Appends the parts of a convex polygon outside of a convex region.
void subtract(Polygon polygon, std::span<const HalfSpace> region, double tolerance_m,
              std::vector<Polygon>& rest) {
  if (!meets(polygon, region, tolerance_m)) return rest.push_back(std::move(polygon));
  for (const HalfSpace& plane : region) {
    const HalfSpace opposite{-plane.normal, -plane.offset};
    if (is_outside(polygon, opposite, tolerance_m)) continue;
    rest.push_back(clip_polygon(polygon, opposite));
    polygon = clip_polygon(polygon, plane);
  }
}

// The corners from a to b, not including b, among points on that edge.
void append_edge(const Vector3d& a, const Vector3d& b, const Polygon& points, double tolerance_m,
                 Polygon& result) {
  const double length = (b - a).norm();
  const Vector3d direction = (b - a) / length;
  std::vector<std::pair<double, Vector3d>> on_edge = {{0, a}, {length, b}};
  for (const Vector3d& x : points) {
    const double along = direction.dot(x - a);
    if (along <= tolerance_m || along >= length - tolerance_m) continue;
    if (direction.cross(x - a).norm() <= tolerance_m) on_edge.emplace_back(along, x);
  }
  std::ranges::sort(on_edge, {}, &std::pair<double, Vector3d>::first);
  for (std::size_t i = 0; i + 1 < on_edge.size(); ++i)
    if (i == 0 || on_edge[i].first - on_edge[i - 1].first > tolerance_m)
      result.push_back(on_edge[i].second);
}

std::vector<Polygon> with_shared_corners(const std::vector<Polygon>& parts, double tolerance_m) {
  Polygon points;
  for (const Polygon& part : parts) points.insert(points.end(), part.begin(), part.end());
  std::vector<Polygon> result;
  for (const Polygon& part : parts) {
    Polygon& shared = result.emplace_back();
    for (std::size_t i = 0; i < part.size(); ++i)
      append_edge(part[i], part[(i + 1) % part.size()], points, tolerance_m, shared);
  }
  return result;
}

}  // namespace

// In a common plane, where heights are 0 to rounding, the plane of a sheet that lies on the other
// is moved towards the eye, and that of a sheet below it away: by twice the tolerance of the cuts.
Shadows::Shadows(std::vector<Sheet> sheets, const Lens& lens, const Pose& camera_from_world)
    : sheets_(std::move(sheets)), all_(sheets_.size()) {
  for (Sheet& sheet : sheets_) sheet = in_frame(std::move(sheet), camera_from_world);
  tolerance_m_ = kTouching * scene_size(sheets_);
  std::iota(all_.begin(), all_.end(), std::size_t{0});
  const auto* parallel = std::get_if<Parallel>(&lens);
  eye_ = parallel ? Eye{-parallel->ray_in_camera({0, 0})->direction, 0} : Eye{Vector3d::Zero(), 1};
  for (const Sheet& sheet : sheets_)
    shadows_.push_back(
        {half_spaces(sheet, 2 * tolerance_m_), half_spaces(sheet, -2 * tolerance_m_)});
}

bool Shadows::faces(std::size_t sheet) const { return side(sheets_[sheet]) > 0; }

// The side of a sheet's plane on which the eye is: 1 for the front, -1 for the back, 0 in the
// plane.
int Shadows::side(const Sheet& sheet) const {
  const double height = sheet.normal.dot(eye_.towards_from(sheet.corners.front()));
  if (std::abs(height) <= (eye_.w == 0 ? kTouching : tolerance_m_)) return 0;
  return height > 0 ? 1 : -1;
}

std::vector<HalfSpace> Shadows::half_spaces(const Sheet& sheet, double lift_m) const {
  const int on = side(sheet);
  if (on == 0) return {};
  const Vector3d beyond = -on * sheet.normal;
  std::vector<HalfSpace> planes = {{beyond, beyond.dot(sheet.corners.front()) + lift_m}};
  for (std::size_t i = 0; i < sheet.corners.size(); ++i) {
    const Vector3d& a = sheet.corners[i];
    const Vector3d edge = sheet.corners[(i + 1) % sheet.corners.size()] - a;
    const Vector3d inside = on * eye_.towards_from(a).cross(edge).normalized();
    planes.push_back({inside, inside.dot(a)});
  }
  return planes;
}

std::span<const HalfSpace> Shadows::shadow(std::size_t sheet, std::size_t own) const {
  if (sheet == own) return {};
  return shadows_[sheet][sheet > own ? 1 : 0];
}

std::optional<std::size_t> Shadows::seen_instead(const Vector3d& x, std::size_t own) const {
  std::optional<std::size_t> front;
  double farthest = 0;
  const Vector3d towards = eye_.towards_from(x).normalized();
  for (std::size_t i = 0; i < shadows_.size(); ++i) {
    const std::span<const HalfSpace> planes = shadow(i, own);
    if (planes.empty() || !contains(planes, x)) continue;
    const HalfSpace& beyond = shadows_[i][0].front();
    const double distance = -beyond.height(x) / beyond.normal.dot(towards);
    if (front && distance < farthest - tolerance_m_) continue;
    front = i;
    farthest = distance;
  }
  return front;
}

Vector3d Shadows::in_line(std::size_t sheet, const Vector3d& x) const {
  const Vector3d towards = eye_.towards_from(x);
  const Sheet& plane = sheets_[sheet];
  return x + plane.normal.dot(plane.corners.front() - x) / plane.normal.dot(towards) * towards;
}

std::vector<Polygon> Shadows::visible_parts(Polygon polygon, std::size_t own,
                                            std::span<const std::size_t> hidden_by) const {
  if (shadows_[own][0].empty()) return {};
  std::vector<Polygon> parts = {std::move(polygon)};
  for (const std::size_t i : hidden_by) {
    std::vector<Polygon> rest;
    for (Polygon& part : parts) subtract(std::move(part), shadow(i, own), tolerance_m_, rest);
    parts = std::move(rest);
  }
  return parts.size() > 1 ? with_shared_corners(parts, tolerance_m_) : parts;
}

}  // namespace tagcal
