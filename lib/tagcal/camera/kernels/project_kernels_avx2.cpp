// Compiled with -mavx2 -mfma on x86-64 (lib/CMakeLists.txt); see project_kernels.hpp for what must
// not be included here. Everywhere else there are no such kernels.
#include "tagcal/camera/kernels/project_kernels.hpp"

#if defined(__AVX2__) && defined(__FMA__)

#include "tagcal/camera/kernels/kernel_table.hpp"

namespace tagcal::internal {

constinit const ProjectKernels kAvx2Kernels = kernels_for<Doubles>();

}  // namespace tagcal::internal

#else

namespace tagcal::internal {

constinit const ProjectKernels kAvx2Kernels = {};

}  // namespace tagcal::internal

#endif
