#pragma once

#include "tagcal/camera/kernels/project_loop.hpp"
#include "tagcal/camera/kernels/sum_loop.hpp"

// All kernels for one kind of pack. Included by the files of kernels only.

namespace tagcal::internal {
namespace {

template <typename LensKernel, typename Pack>
constexpr void fill(ProjectKernelKind kind, ProjectKernels& kernels) {
  kernels.pixels[kind] = ProjectLoop<LensKernel, Pack, false>::run;
  kernels.with_jacobians[kind] = ProjectLoop<LensKernel, Pack, true>::run;
  kernels.sums_pose[kind] = SumLoop<LensKernel, Pack, kNoColumn>::run;
  kernels.sums_pose_and_focal[kind] = SumLoop<LensKernel, Pack, kFocalColumn>::run;
  kernels.sums_with_parameters[kind] = SumLoop<LensKernel, Pack, kFreeColumns>::run;
}

template <typename Pack>
constexpr ProjectKernels kernels_for() {
  ProjectKernels kernels;
  fill<PerspectiveKernel<kPinhole>, Pack>(kPinhole, kernels);
  fill<PerspectiveKernel<kBrownConrady>, Pack>(kBrownConrady, kernels);
  fill<PerspectiveKernel<kRational>, Pack>(kRational, kernels);
  fill<FisheyeKernel, Pack>(kFisheye, kernels);
  fill<ParallelKernel, Pack>(kParallel, kernels);
  return kernels;
}

}  // namespace
}  // namespace tagcal::internal
