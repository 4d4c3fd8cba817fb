#pragma once

#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/kernels/project_kernels.hpp"

namespace tagcal::internal {

// The kernels for the processor that this runs on.
const ProjectKernels& fastest_kernels();

// Sets the lens of a job; returns which of the kernels is its. Columns are wanted of the lens
// parameters whose bit is set in `wanted`.
ProjectKernelKind set_lens(const Lens& lens, unsigned wanted, ViewJob& job);

// The columns of free parameters as sets of lens parameters, for `columns` of a job; returns their
// union. Throws Error for a parameter that the lens does not have.
unsigned set_columns(std::span<const FreeParameter> free, std::size_t num_parameters,
                     unsigned* columns);

// project_with_jacobians by kernels of choice; without by_pose and by_parameters, project.
std::size_t project_by(const ProjectKernels& kernels, const Lens& lens,
                       const Pose& camera_from_source, std::span<const Eigen::Vector3d> x_in_source,
                       std::span<const FreeParameter> free, const ProjectionOutput& output);

}  // namespace tagcal::internal
