#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace tagcal::internal {

// Normalised frame of points, so that solvers do not depend on the unit or the origin of a target:
// centred, of unit RMS size, axes along the spread, the longest first.
struct PointFrame {
  Eigen::Matrix3d axes;     // rows: frame_from_target, det = +1
  Eigen::Vector3d centre;   // in the target frame
  double size = 0;          // RMS distance from the centre
  Eigen::Vector3d extents;  // RMS along the axes / size

  Eigen::Vector3d operator()(const Eigen::Vector3d& x_in_target) const {
    return axes * (x_in_target - centre) / size;
  }
};

// No value if the points lie on a line or at one place (an extent across the longest axis below
// 1e-6 of the size, or below the rounding of the coordinates), or are not finite.
std::optional<PointFrame> point_frame(std::span<const Eigen::Vector3d> points);

}  // namespace tagcal::internal
