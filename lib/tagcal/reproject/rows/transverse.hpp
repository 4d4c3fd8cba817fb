#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tagcal::internal {

// The angles of a direction towards the axis x and about it, from z to y
// (PanoramaKind::transverse).
inline Eigen::Vector2d transverse_angles(const Eigen::Vector3d& direction) {
  return {std::atan2(direction.x(), direction.tail<2>().norm()),
          std::atan2(direction.y(), direction.z())};
}

}  // namespace tagcal::internal
