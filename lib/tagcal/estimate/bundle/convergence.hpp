#pragma once

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// Continues a bundle whose solver ran out of iterations, in rounds of `max_iterations`, until the
// solver converges or the projection is stationary: along correlated coefficients the cost has a
// long flat valley in which no corner moves. The projection is stationary if a round moves the
// corners (RMS) by less than policy::kStationaryShare of their standard deviation; `converged` is
// true then, too. Stops at once if the parameters are unobservable.
void continue_until_converged(Bundle& bundle, BundleSummary& summary, int max_iterations);

// True if the solver stopped at no minimum: a point would leave the domain of the lens, and a
// Gauss-Newton step would lower the cost by more than policy::kLargestDecrement.
bool stuck_at_domain_limit(const Bundle& bundle, const BundleSummary& summary);

// Distance between the projections of the same corners in two states of a bundle.
struct PixelDisplacement {
  double rms_px = 0;
  double max_px = 0;
};
PixelDisplacement pixel_displacement(const Bundle& a, const Bundle& b);

}  // namespace tagcal::internal
