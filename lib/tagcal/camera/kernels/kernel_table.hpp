#pragma once

#include "tagcal/camera/kernels/project_loop.hpp"
#include "tagcal/camera/kernels/sum_loop.hpp"

// All kernels for one kind of pack. Included by the files of kernels only.

namespace tagcal::internal {
namespace {

template <typename Pack>
constexpr ProjectKernels kernels_for() {
  ProjectKernels kernels;
  for_each_kernel([&]<typename LensKernel>(ProjectKernelKind kind) {
    kernels.pixels[kind] = ProjectLoop<LensKernel, Pack, false>::run;
    kernels.with_jacobians[kind] = ProjectLoop<LensKernel, Pack, true>::run;
    kernels.sums_pose[kind] = SumLoop<LensKernel, Pack, kNoColumn>::run;
    kernels.sums_pose_and_focal[kind] = SumLoop<LensKernel, Pack, kFocalColumn>::run;
    kernels.sums_with_parameters[kind] = SumLoop<LensKernel, Pack, kFreeColumns>::run;
  });
  return kernels;
}

}  // namespace
}  // namespace tagcal::internal
