#include "tagcal/camera/kernels/kernel_table.hpp"

namespace tagcal::internal {

constinit const ProjectKernels kPortableKernels = kernels_for<double>();

}  // namespace tagcal::internal
