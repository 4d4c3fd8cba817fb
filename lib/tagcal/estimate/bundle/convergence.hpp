#pragma once

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// Goes on with a bundle whose solver ran out of iterations, by `max_iterations` at a time, until it
// converges or the projection stands still: where coefficients trade with one another, the solver
// follows them down a long flat valley in which no corner moves. `converged` says either: that the
// corners moved, over as many iterations, by less than a tenth of what the noise of the residuals
// leaves of them uncertain (RMS). What the data do not hold where it stands has no end to go to: it
// stays as it is.
void settle(Bundle& bundle, BundleSummary& summary, int max_iterations);

// Whether what a solver calls converged is no minimum: it stands where a point would leave the
// domain of the lens, and a Gauss-Newton step would lower the cost by more than noise can
// (`kLargestDecrement`).
bool at_fold(const Bundle& bundle, const BundleSummary& summary);

// How far two states of the same corners put them from each other.
struct Moved {
  double rms_px = 0;
  double max_px = 0;
};
Moved moved(const Bundle& a, const Bundle& b);

}  // namespace tagcal::internal
