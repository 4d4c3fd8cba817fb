#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// The test of whether a model's parameters are determined at its estimate. The exact inverse of the
// information decides, by the standard deviations of the focal length and of the projection at
// infinity.
// Condition numbers and pseudo-inverses do not tell. Single coefficients are not judged: if some
// are unobservable but the projection does not depend on them (k1 and k4 of a rational lens for a
// camera without distortion), the status is ok, `open` names them, and the covariance gives them a
// million times the standard deviations that they had alone.
struct Observability {
  Status status = Status::ok;  // or degenerate, focal_not_observable, not_observable
  std::string reason;          // a sentence, if the status is not ok
  double focal_share = 0;      // sd(f) / f
  double projection_px = 0;    // standard deviation of the projection at infinity, RMS over corners
  std::vector<std::string> open;               // unobservable coefficients
  std::optional<BundleCovariance> covariance;  // none if the information has no inverse
};

// `sigma`: noise per (whitened) coordinate.
Observability observability(const Bundle& bundle, double sigma);
Observability observability(const Bundle& bundle,
                            const std::optional<BundleInformation>& information, double sigma);

// The largest sd(f) / f of the focal lengths, by a covariance of the bundle's free parameters.
double relative_focal_sigma(const Bundle& bundle, const Eigen::MatrixXd& covariance);

// Sets `focal_share` from the covariance, and refuses the focal length above policy::kFocalRefused.
void judge_focal_length(Observability& result, const Bundle& bundle);

// Continues a bundle whose solver ran out of iterations, in rounds of `max_iterations`, until the
// solver converges, or until a round lowers the cost by less than policy::kStationaryDecrease times
// the noise's variance for each parameter: along correlated coefficients the cost has a long flat
// valley in which no corner moves. `converged` is true then, too. Stops at once if the parameters
// are unobservable.
void continue_until_converged(Bundle& bundle, BundleSummary& summary, int max_iterations);

// True if the solver stopped at no minimum: a point would leave the domain of the lens, and a
// Gauss-Newton step would lower the cost by more than policy::kLargestDecrement.
bool stuck_at_domain_limit(const Bundle& bundle, const BundleSummary& summary);

SeenRegion seen_region(const Bundle& bundle);
double median_distance_m(const Bundle& bundle);  // from the camera to the corners

int num_corners(const Bundle& bundle);
int degrees_of_freedom(const Bundle& bundle);  // number of residuals - parameters - 6 per pose

}  // namespace tagcal::internal
