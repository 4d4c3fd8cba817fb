#pragma once

#include "tagcal/reproject/kernels/map_loop.hpp"
#include "tagcal/reproject/kernels/mean_loop.hpp"
#include "tagcal/reproject/kernels/resample_loop.hpp"

// All kernels for one kind of pack. Included by the files of kernels only.

namespace tagcal::internal {
namespace {

template <typename T, int kValues>
constexpr void fill_resampling(PixelKind kind, ReprojectKernels& kernels) {
  kernels.nearest[kind] = nearest_row<T, kValues>;
  kernels.bilinear[kind] = bilinear_row<T, kValues>;
  kernels.lanczos[kind] = lanczos_row<T, kValues>;
  kernels.tent_mean[kind] = mean_pixel<T, kValues, false>;
  kernels.lanczos_mean[kind] = mean_pixel<T, kValues, true>;
}

template <typename Pack>
constexpr ReprojectKernels reproject_kernels_for() {
  ReprojectKernels kernels;
  for_each_kernel([&]<typename LensKernel>(ProjectKernelKind kind) {
    kernels.map_row[kind] = MapLoop<LensKernel, Pack>::run;
  });
  fill_resampling<unsigned char, 1>(kGrey8, kernels);
  fill_resampling<unsigned short, 1>(kGrey16, kernels);
  fill_resampling<unsigned char, 3>(kColour8, kernels);
  fill_resampling<unsigned short, 3>(kColour16, kernels);
  return kernels;
}

}  // namespace
}  // namespace tagcal::internal
