#pragma once

#include "tagcal/estimate/refine.hpp"

namespace tagcal {

// Goes on with a bundle whose solver ran out of iterations, by `max_iterations` at a time, until it
// converges or the projection stands still: where coefficients trade with one another, the solver
// follows them down a long flat valley in which no corner moves. `converged` says either: that the
// corners moved, over as many iterations, by less than a tenth of what the noise of the residuals
// leaves of them uncertain (RMS).
void settle(Bundle& bundle, BundleSummary& summary, int max_iterations);

// How far two states of the same corners put them from each other.
struct Moved {
  double rms_px = 0;
  double max_px = 0;
};
Moved moved(const Bundle& a, const Bundle& b);

}  // namespace tagcal
