#pragma once

#include "tagcal/reproject/kernels/reproject_kernels.hpp"

namespace tagcal::internal {

// The fastest kernels for the processor that runs the program.
const ReprojectKernels& fastest_reproject_kernels();

// Weights of Lanczos' kernel with four lobes, for kPhases + 1 fractions of a pixel from 0 to 1 and
// the taps -3 .. 4; each row sums to 1.
const float* lanczos_phases();

// The kernel at the distances i / kProfileSteps, 0 from distance 4 on.
const float* lanczos_profile();

// sinc(x) sinc(x / 4) for |x| < 4, else 0.
double lanczos_weight(double x);

}  // namespace tagcal::internal
