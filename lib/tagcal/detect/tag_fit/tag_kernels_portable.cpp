#include "tagcal/detect/tag_fit/tag_kernels.hpp"

#include "tagcal/detect/tag_fit/tag_kernel_loops.hpp"
#include "tagcal/internal/processor.hpp"

namespace tagcal::internal {

constinit const TagKernels kPortableTagKernels = {select, add_ends, evaluate, add_products,
                                                  add_light_products};

const TagKernels& fastest_tag_kernels() {
  static const bool is_avx2 = kAvx2TagKernels.select && runs_avx2();
  return is_avx2 ? kAvx2TagKernels : kPortableTagKernels;
}

}  // namespace tagcal::internal
