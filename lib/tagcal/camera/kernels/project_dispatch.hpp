#pragma once

#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/kernels/project_kernels.hpp"

namespace tagcal::internal {

// The fastest kernels for the processor that runs the program.
const ProjectKernels& fastest_kernels();

// Sets the lens of a job and returns the kind of its kernel. A bit of `wanted` asks for the columns
// of that lens parameter.
ProjectKernelKind set_lens(const Lens& lens, unsigned wanted, ViewJob& job);

// Writes the set of lens parameters of each free parameter to `columns` of a job; returns their
// union. Throws Error for a parameter that the lens does not have.
unsigned set_columns(std::span<const FreeParameter> free, std::size_t num_parameters,
                     unsigned* columns);

// project_with_jacobians by the given kernels; `project` if by_pose and by_parameters are empty.
std::size_t project_by(const ProjectKernels& kernels, const Lens& lens,
                       const Pose& camera_from_source, std::span<const Eigen::Vector3d> x_in_source,
                       std::span<const FreeParameter> free, const ProjectionOutput& output);

}  // namespace tagcal::internal
