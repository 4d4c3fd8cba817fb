#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/estimate/solutions.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal {

// The poses of three points or more in any configuration but a line: a plane, nearly a plane, in
// space. They are the minima of the error in space,
//   sum_i |(1 - v_i v_i') (R x_i + t)|^2,  v_i the unit rays,
// over rotations, t eliminated: a form r' Omega r in the nine numbers of R (Terzakis & Lourakis,
// ECCV 2020). All minima with every point in front of the camera that are found, the best first.
// Rays are directions in the camera frame of any length but zero. det R = +1, nothing is NaN, and
// neither the unit nor the origin of the target matters. None for points on a line, NaN, or where
// every minimum puts a point behind the camera.
Solutions<Pose, 4> pnp(std::span<const Eigen::Vector3d> points,
                       std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal
