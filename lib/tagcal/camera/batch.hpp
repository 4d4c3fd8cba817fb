#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "tagcal/camera/model.hpp"
#include "tagcal/geometry/pose.hpp"

// Many points at once with Jacobians, as solvers need them. Pixels alone: `project` in lens.hpp.
// Both use the fastest instructions that the processor has, found at run time; a point's result
// does not depend on its place or its neighbours, and agrees with the single-point functions of the
// lens to rounding. So does the border of the domain: a point within rounding of it may be on
// either side.

namespace tagcal {

// Where project_with_jacobians writes; n points, memory of the caller's. Jacobians are row-major,
// rows 2i and 2i + 1 for u and v of point i.
struct ProjectionOutput {
  std::span<Eigen::Vector2d> pixels;     // n
  std::span<std::uint8_t> valid;         // n
  std::span<double> by_pose = {};        // 2n x 6, or empty: not wanted
  std::span<double> by_parameters = {};  // 2n x free.size(), or empty: not wanted
};

// The chain source -> camera -> image with its Jacobians by
//   the step (omega, tau) of `retract` (geometry/pose.hpp): R <- exp(omega) R, t <- t + tau;
//   the free parameters of a model (camera/model.hpp), in their order: of a tied one (f: fx and fy)
//   the sum over the lens parameters that it sets.
// valid[i] says whether point i is in the domain; of one that is not, pixel and rows are NaN.
// Returns how many are. Throws Error where a size does not fit, for a parameter that the lens does
// not have, and for more free parameters than it has.
std::size_t project_with_jacobians(const Lens& lens, const Pose& camera_from_source,
                                   std::span<const Eigen::Vector3d> x_in_source,
                                   std::span<const FreeParameter> free,
                                   const ProjectionOutput& output);

}  // namespace tagcal
