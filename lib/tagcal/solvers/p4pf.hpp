#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/solutions.hpp"

namespace tagcal {

struct PoseAndFocal {
  Pose camera_from_target;
  double focal_px = 0;
};

// Returns up to six poses with focal length of four points in space, not in a plane, whose pixels
// are relative to the principal point of a pinhole with square pixels (problem of Bujnak, Kukelova
// & Pajdla, CVPR 2008). With barycentric gradients n_k of the points P_k (about their centroid) and
// r3 the third row of the rotation over the depth of the centroid, the depth of point k is
// proportional to 1 + r3 . P_k and its image times that is affine in P_k, so that the other two
// rows, to one scale, are
//   r1 = sum_k x_k (1 + r3 . P_k) n_k,  r2 = sum_k y_k (1 + r3 . P_k) n_k.
// r3 . r1 = r3 . r2 = r1 . r2 = |r1|^2 - |r2|^2 = 0 are four quadrics in the three unknowns r3.
// Eliminating two unknowns leaves a polynomial of degree 6 in the third. The focal length is then
// |r1| / |r3|.
// There are eight equations for seven unknowns: without noise there is usually one solution; with
// noise the solutions fit the points approximately. They are the roots of the polynomial, and the
// minima of the squares of the angles between the rows and of |r1| / |r2| - 1 that Gauss-Newton
// steps reach from them: the six of least squares, below 1. Both are needed to start a
// refinement, because one minimum of these squares may stand for two of the reprojection error.
// Empty for points in a plane (a height below 1e-7 of the size, or lost in the rounding of the
// coordinates), pixels at one place, or input that is not finite; also if an equation degenerates:
// two points at the principal point, and the other two in orthogonal directions from it and from
// the first.
Solutions<PoseAndFocal, 6> p4pf(std::span<const Eigen::Vector3d, 4> points,
                                std::span<const Eigen::Vector2d, 4> pixels_from_centre);

}  // namespace tagcal
