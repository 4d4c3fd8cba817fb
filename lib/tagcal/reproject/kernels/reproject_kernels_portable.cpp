#include "tagcal/reproject/kernels/reproject_table.hpp"

namespace tagcal::internal {

constinit const ReprojectKernels kPortableReprojectKernels = reproject_kernels_for<double>();

}  // namespace tagcal::internal
