#include "tagcal/scene/visibility/polygon.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tagcal::internal {

using Eigen::Vector3d;

std::optional<std::string> why_no_polygon(std::span<const Vector3d> corners) {
  const std::size_t n = corners.size();
  Vector3d normal = Vector3d::Zero();  // its length is twice the area
  double size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % n] - corners[0]);
    size = std::max(size, (corners[i] - corners[0]).norm());
  }
  if (!(normal.norm() > 1e-9 * size * size)) return "must not lie on a line";
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
  if (turned > 3 * std::numbers::pi) return "must be convex, but its sides cross";
  return std::nullopt;
}

}  // namespace tagcal::internal
