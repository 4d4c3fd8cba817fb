#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/estimate/solutions.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal {

// A pose under weak perspective (scaled orthography), all that a view holds when the focal length
// and the distance cannot be told apart: pixel = s (R x + t)_xy + c, with c the principal point,
// s = f / Z. It is the Parallel lens (s, s, cx, cy); the translation's z is 0.
struct WeakPerspectivePose {
  Pose camera_from_target;
  double scale_px_per_m = 0;
  double rms_px = 0;  // sqrt(sum |r|^2 / points)
};

// The least-squares poses of four points or more, pixels relative to c: one for points in space,
// two for a plane (the tilt's sign cannot be seen, Oberkampf, DeMenthon & Davis, CVIU 1996), best
// first. PAPER AND EQUATIONS HERE. None for points on a line or not finite.
Solutions<WeakPerspectivePose, 2> weak_perspective_poses(
    std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector2d> pixels_from_centre);

}  // namespace tagcal
