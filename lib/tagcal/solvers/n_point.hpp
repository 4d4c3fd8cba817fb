#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/solutions.hpp"

namespace tagcal {

// The poses of three points or more in any configuration but a line: a plane, nearly a plane, in
// space. They are the minima of the error in space (Lu, Hager & Mjolsness, PAMI 2000, eq. 19),
//   sum_i |(1 - v_i v_i') (R x_i + t)|^2,  v_i the unit rays.
// t goes out by linear least squares, which leaves a form r' Omega r in the nine numbers of R
// (Terzakis & Lourakis, ECCV 2020, eqs. 5-9), summed up in one pass over the points; Newton steps
// on SO(3) lead to its minima. They start, as in that paper, from the smallest eigenvectors of
// Omega (of a plane: of its 6x6 block for the two columns of R in the plane), and from the minima
// found, with the tilt towards the line of sight the other way; with fewer than six points, whose
// eigenvectors say little, also from twelve rotations spread over all.
//
// All minima that were found with every point in front of the camera, the best first. That the
// global one is among them is measured, not proven: none missed in 10^4 draws of each setting of
// six points or more, about one in 10^4 of four points seen at a wide angle. Three points: the
// solutions of P3P, of which 0.2 % are missed; `p3p` gives all.
//
// Rays are directions in the camera frame of any length but zero; in front means along the ray, so
// that a view beyond 180 degrees is no exception. det R = +1, nothing is NaN, and neither the unit
// nor the origin of the target matters. None for points on a line or at one place (an extent across
// the longest axis below 1e-6 of the size), for rays that coincide, for numbers that are not
// finite, and where every minimum puts a point behind the camera. With noise the minimum is a start
// for the maximum of likelihood, not that itself: the error is weighted by distance.
Solutions<Pose, 4> pnp(std::span<const Eigen::Vector3d> points,
                       std::span<const Eigen::Vector3d> rays);

// The pose of six points or more in space, not in a plane, by the normalised direct linear
// transformation (Hartley & Zisserman 2004, algorithm 7.1) and the nearest rotation.
std::optional<Pose> pose_from_points_dlt(std::span<const Eigen::Vector3d> points,
                                         std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal
