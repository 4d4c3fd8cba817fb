#pragma once

#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/project_kernels.hpp"

namespace tagcal {

// The kernels for the processor that this runs on.
const ProjectKernels& fastest_kernels();

// project_with_jacobians by kernels of choice; without by_pose and by_parameters, project.
std::size_t project_by(const ProjectKernels& kernels, const Lens& lens,
                       const Pose& camera_from_source, std::span<const Eigen::Vector3d> x_in_source,
                       std::span<const FreeParameter> free, const ProjectionOutput& output);

}  // namespace tagcal
