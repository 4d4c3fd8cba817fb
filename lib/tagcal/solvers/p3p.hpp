#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/solutions.hpp"

// Poses from the fewest points, exact without noise. A solver returns all solutions with every
// point in front of the camera, in no order; none if the points do not determine one. Rotations
// have det = +1, no number is NaN, and the result does not depend on the unit or the origin of the
// target.

namespace tagcal {

// Returns up to four poses of three points with known rays. Rays are directions in the camera frame
// of any length but zero; "in front" means along the ray. The distances d_i along unit rays m_i
// solve
//   d_i^2 + d_j^2 - 2 (m_i . m_j) d_i d_j = |X_i - X_j|^2,
// the intersection of two conics in (d_1 : d_2 : d_3): a degenerate conic of their pencil is two
// lines, and each meets a conic twice (Persson & Nordberg, ECCV 2018; Ding et al., CVPR 2023). Here
// the conics are in differences of distances, so that distant targets lose no digits, the root of
// the pencil's cubic is the one farthest from the other two, and Newton's method refines the
// result. Every solution reproduces the rays to 1e-9. On the danger cylinder (through the three
// points, perpendicular to their plane) two solutions coincide, and a rounding of e in the rays
// moves them by sqrt(e), about 1e-8 of the distance; only one may be returned. Empty for points on
// a line (height below 1e-9 of the longest side, or lost in the rounding of the coordinates), rays
// that coincide, or input that is not finite.
Solutions<Pose, 4> p3p(std::span<const Eigen::Vector3d, 3> points,
                       std::span<const Eigen::Vector3d, 3> rays);

}  // namespace tagcal
