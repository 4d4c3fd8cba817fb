#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/estimate/solutions.hpp"
#include "tagcal/geometry/pose.hpp"

// Poses from the fewest points, exact without noise. Each solver returns all solutions with every
// point in front of the camera, in no order; none where the points do not fix one. Rotations have
// det = +1, nothing is NaN, and neither the unit nor the origin of the target matters.

namespace tagcal {

// Three points with known rays: up to four poses. Rays are directions in the camera frame of any
// length but zero; in front means along the ray. PAPER AND EQUATIONS HERE.
// None for points or rays on a line or at one place.
Solutions<Pose, 4> p3p(std::span<const Eigen::Vector3d, 3> points,
                       std::span<const Eigen::Vector3d, 3> rays);

struct PoseAndFocal {
  Pose camera_from_target;
  double focal_px = 0;
};

// Four points in space, not in a plane, with pixels relative to the principal point of a pinhole
// with square pixels: up to six poses with their focal lengths. PAPER AND EQUATIONS HERE.
// Eight equations for seven unknowns: with noise the solutions fit the points nearly.
Solutions<PoseAndFocal, 6> p4pf(std::span<const Eigen::Vector3d, 4> points,
                                std::span<const Eigen::Vector2d, 4> pixels_from_centre);

}  // namespace tagcal
