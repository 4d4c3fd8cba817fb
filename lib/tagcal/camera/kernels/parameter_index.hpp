#pragma once

namespace tagcal::internal {

// Indices into Perspective::Parameters, and the last two of Parallel::Parameters. (No includes
// here: the kernels of batch projection, which are compiled for one kind of processor, use it.)
enum PerspectiveIndex { kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kK4, kK5, kK6 };
enum ParallelIndex { kOx = 4, kOy };

}  // namespace tagcal::internal
