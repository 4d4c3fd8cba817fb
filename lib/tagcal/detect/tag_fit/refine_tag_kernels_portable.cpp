#include "tagcal/detect/tag_fit/refine_tag_kernels.hpp"

#include "tagcal/detect/tag_fit/refine_tag_kernel_loops.hpp"

namespace tagcal::internal {

constinit const TagKernels kPortableTagKernels = {select, evaluate, add_products};

const TagKernels& fastest_tag_kernels() {
  static const TagKernels* const kernels = [] {
#if defined(__x86_64__)
    if (kAvx2TagKernels.select && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
      return &kAvx2TagKernels;
#endif
    return &kPortableTagKernels;
  }();
  return *kernels;
}

}  // namespace tagcal::internal
