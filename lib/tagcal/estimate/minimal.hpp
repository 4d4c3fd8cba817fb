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
// length but zero; in front means along the ray. The distances d_i along unit rays m_i solve
//   d_i^2 + d_j^2 - 2 (m_i . m_j) d_i d_j = |X_i - X_j|^2,
// which is where two conics in (d_1 : d_2 : d_3) meet: a degenerate conic of their pencil is two
// lines, and each meets a conic twice (Persson & Nordberg, ECCV 2018; Ding et al., CVPR 2023). Here
// the conics are in differences of distances, so that distant targets lose no digits, the root of
// the pencil's cubic is the one farthest from the other two, and Newton's method ends it.
// Every solution reproduces the rays to 1e-9. On the danger cylinder (through the three points,
// square to their plane) two solutions are one and a rounding of e in the rays moves them by
// sqrt(e), about 1e-8 of the distance; they may then come as one. None for points on a line (height
// below 1e-9 of the longest side, or lost in the rounding of the coordinates), rays that are all
// one, or input that is not finite.
Solutions<Pose, 4> p3p(std::span<const Eigen::Vector3d, 3> points,
                       std::span<const Eigen::Vector3d, 3> rays);

struct PoseAndFocal {
  Pose camera_from_target;
  double focal_px = 0;
};

// Four points in space, not in a plane, with pixels relative to the principal point of a pinhole
// with square pixels: up to six poses with their focal lengths (the problem: Bujnak, Kukelova &
// Pajdla, CVPR 2008). With barycentric gradients n_k of the points P_k (about their centroid) and
// r3 the third row of the rotation over the depth of the centroid, the depth of point k is
// proportional to 1 + r3 . P_k and its image times that is affine in P_k, so that the other two
// rows, to one scale, are
//   r1 = sum_k x_k (1 + r3 . P_k) n_k,  r2 = sum_k y_k (1 + r3 . P_k) n_k.
// r3 . r1 = r3 . r2 = r1 . r2 = |r1|^2 - |r2|^2 = 0 are four quadrics in the three unknowns r3; one
// unknown kept aside, they leave a polynomial of degree 6 in it. Then |r1| / |r3| is the focal
// length.
// Eight equations for seven unknowns: without noise there is one solution, as a rule; with noise
// the solutions fit the points nearly. They are the least squares of the angles between the rows
// and of |r1| / |r2| - 1, none above 0.1. None for points in a plane (a height below 1e-7 of the
// size, or lost in the rounding of the coordinates), pixels at one place, or input that is not
// finite; nor where an equation is lost: two points at the principal point and the other two in
// directions from it, and from the first, that are orthogonal.
Solutions<PoseAndFocal, 6> p4pf(std::span<const Eigen::Vector3d, 4> points,
                                std::span<const Eigen::Vector2d, 4> pixels_from_centre);

}  // namespace tagcal
