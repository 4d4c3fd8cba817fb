#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "tagcal/camera/model.hpp"
#include "tagcal/geometry/pose.hpp"

// Projects many points at once with Jacobians; `project` in lens.hpp gives the pixels alone. Both
// use the fastest instructions that the processor has, found at run time. The result of a point
// does not depend on its index or its neighbours, and agrees with the single-point functions of the
// lens to rounding; a point within rounding of the domain's border may be on either side.

namespace tagcal {

// The caller's memory for the results of project_with_jacobians for n points. Jacobians are
// row-major; rows 2i and 2i + 1 belong to u and v of point i.
struct ProjectionOutput {
  std::span<Eigen::Vector2d> pixels;     // n
  std::span<std::uint8_t> valid;         // n
  std::span<double> by_pose = {};        // 2n x 6, or empty: not wanted
  std::span<double> by_parameters = {};  // 2n x free.size(), or empty: not wanted
};

// The chain source -> camera -> image with its Jacobians by
//   the step (omega, tau) of `retract` (geometry/pose.hpp): R <- exp(omega) R, t <- t + tau;
//   the free parameters of a model (camera/model.hpp), in their order; the column of a tied one
//   (f: fx and fy) is the sum over the lens parameters that it sets.
// valid[i] is 1 if point i is in the domain; otherwise its pixel and rows are NaN. Returns the
// number of valid points. Throws Error if a size does not fit, a parameter is not one of the lens,
// or there are more free parameters than the lens has.
std::size_t project_with_jacobians(const Lens& lens, const Pose& camera_from_source,
                                   std::span<const Eigen::Vector3d> x_in_source,
                                   std::span<const FreeParameter> free,
                                   const ProjectionOutput& output);

}  // namespace tagcal
