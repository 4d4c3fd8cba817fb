#include "tagcal/scene/visibility/polygon.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tagcal::internal {

using Eigen::Vector3d;

namespace {

constexpr double kFlat = 1e-9;  // numeric: of an area and of a distance, relative to the size
constexpr const char* kSidesCross = "must be convex, but its sides cross";

// The parts of a polygon whose sides cross may have areas that cancel.
bool lie_on_a_line(std::span<const Vector3d> corners, double size) {
  const auto farthest = std::ranges::max_element(
      corners, {}, [&](const Vector3d& corner) { return (corner - corners[0]).norm(); });
  const Vector3d line = *farthest - corners[0];
  return std::ranges::all_of(corners, [&](const Vector3d& corner) {
    return line.cross(corner - corners[0]).norm() <= kFlat * size * size;
  });
}

}  // namespace

std::optional<std::string> why_no_polygon(std::span<const Vector3d> corners) {
  const std::size_t n = corners.size();
  Vector3d normal = Vector3d::Zero();  // its length is twice the area
  double size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % n] - corners[0]);
    size = std::max(size, (corners[i] - corners[0]).norm());
  }
  if (!(normal.norm() > kFlat * size * size))
    return lie_on_a_line(corners, size) ? "must not lie on a line" : kSidesCross;
  normal.normalize();
  double turned = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::abs((corners[i] - corners[0]).dot(normal)) > 1e-6 * size)
      return fmt::format("must lie in a plane, but corner {} does not", i);
    const Vector3d side = corners[(i + 1) % n] - corners[i];
    const Vector3d next = corners[(i + 2) % n] - corners[(i + 1) % n];
    const double turn = std::atan2(side.cross(next).dot(normal), side.dot(next));
    if (turn < -1e-6 || side.isZero())
      return fmt::format("must be convex, but is not at corner {}", (i + 1) % n);
    turned += turn;
  }
  // A pentagram turns left at each corner too, but twice around.
  if (turned > 3 * std::numbers::pi) return kSidesCross;
  return std::nullopt;
}

}  // namespace tagcal::internal
