// Compiled with -mavx2 -mfma on x86-64 (lib/CMakeLists.txt); tag_kernels.hpp lists the
// headers that may be included here. On other processors these kernels do not exist.
#include "tagcal/detect/tag_fit/tag_kernels.hpp"

#if defined(__AVX2__) && defined(__FMA__)

#include "tagcal/detect/tag_fit/tag_kernel_loops.hpp"

namespace tagcal::internal {

constinit const TagKernels kAvx2TagKernels = {select, add_ends, evaluate, add_products,
                                              add_light_products};

}  // namespace tagcal::internal

#else

namespace tagcal::internal {

constinit const TagKernels kAvx2TagKernels = {};

}  // namespace tagcal::internal

#endif
