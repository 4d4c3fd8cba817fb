#pragma once

namespace tagcal::internal {

// Tells whether kernels compiled for AVX2 and FMA run: where the processor has both, unless the
// environment variable TAGCAL_PROCESSOR is `any`, with which tests take the other path. Throws
// Error if the variable has another value. What the two paths may differ by:
// tests/same/answers.py.
bool runs_avx2();

}  // namespace tagcal::internal
