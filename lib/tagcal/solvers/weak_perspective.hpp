#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/solutions.hpp"

namespace tagcal {

// A pose under weak perspective (scaled orthography), for views that do not separate the focal
// length from the distance: pixel = s (R x + t)_xy + c, with c the principal point, s = f / Z. It
// is the Parallel lens (s, s, cx, cy); the translation's z is 0.
struct WeakPerspectivePose {
  Pose camera_from_target;
  double scale_px_per_m = 0;
  double rms_px = 0;  // sqrt(sum |r|^2 / points)
};

// Returns the poses of four points or more with the least sum of squares of
//   r_i = s (R x_i + t)_xy - p_i,  p_i the pixels relative to c,
// best first. Centring eliminates t.
//
// A plane has two. With its points at z = 0 the affine fit p = A x is the least-squares answer
// itself, and A = s R_22 for the upper left block of R. s is the larger singular value of A, the
// third column of R's rows is +- the u_2 of the smaller one times sqrt(1 - (sigma_2 / sigma_1)^2)
// (Oberkampf, DeMenthon & Davis, CVIU 1996; algebra of Collins & Bartoli, IJCV 2014, section 3.2,
// without perspective). Both have the same image under weak perspective. They are equal for a
// frontal plane.
//
// Points in space have one: Newton steps on (R, s) start from the scaled rotation nearest to the
// affine fit (the rigid factor of Ullman & Basri, PAMI 1991) and from the two of the best plane. If
// the thickness (RMS distance from the best plane) is below 5 % of the size, both tilts are
// returned if they are different minima.
//
// The result does not depend on the unit or the origin of the target. Empty for fewer than four
// points, points on a line, pixels that all coincide, or numbers that are not finite. Throws
// Error unless there are as many pixels as points.
Solutions<WeakPerspectivePose, 2> weak_perspective_poses(
    std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector2d> pixels_from_centre);

}  // namespace tagcal
