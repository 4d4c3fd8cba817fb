// Compiled with -mavx2 -mfma: no standard library here (see internal/pack.hpp).
#include "tagcal/reproject/kernels/reproject_kernels.hpp"

#if defined(__AVX2__) && defined(__FMA__)

#include "tagcal/reproject/kernels/reproject_table.hpp"

namespace tagcal::internal {

constinit const ReprojectKernels kAvx2ReprojectKernels = reproject_kernels_for<Doubles>();

}  // namespace tagcal::internal

#else

namespace tagcal::internal {

constinit const ReprojectKernels kAvx2ReprojectKernels = {};

}  // namespace tagcal::internal

#endif
