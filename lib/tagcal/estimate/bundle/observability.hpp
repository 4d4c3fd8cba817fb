#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/seen_region.hpp"
#include "tagcal/estimate/status.hpp"

namespace tagcal::internal {

// Whether the data hold the parameters of a model at its estimate, from the exact inverse of the
// information. Condition numbers alone never tell, pseudo-inverses lie: what decides is the
// standard deviation of the focal length and of the projection at infinity. Coefficients are never
// judged: where some trade with one another and the projection knows nothing of it (the rational
// lens of a camera without distortion: k1 with k4), they are `open`, the status is ok, and their
// variances are a million times those that they had alone, of which projections see nothing.
struct Observability {
  Status status = Status::ok;  // or degenerate, focal_not_observable, not_observable
  std::string reason;          // a sentence where it is not ok
  double focal_share = 0;      // sd(f) / f
  double projection_px = 0;    // sd of the projection at infinity, RMS over the corners
  // By how much a Gauss-Newton step would lower the cost, over sigma^2: no minimum where it is
  // large (a valley of trading coefficients has up to 5, a solver stuck at the fold of a lens
  // hundreds).
  double decrement = 0;
  std::vector<std::string> open;               // coefficients that have no value of their own
  std::optional<BundleCovariance> covariance;  // none where the information has no inverse
};

inline constexpr double kFocalWeak = 0.05;  // sd(f) / f
inline constexpr double kProjectionWeakPx = 2.0;
inline constexpr double kLargestDecrement = 30;

// `sigma`: noise per (whitened) coordinate. With `bend_open` the information's two bends are
// estimated, too, and what they leave open counts.
Observability observability(const Bundle& bundle, double sigma);
Observability observability(const Bundle& bundle,
                            const std::optional<BundleInformation>& information, double sigma,
                            bool bend_open = false);

// The largest sd(f) / f of a covariance of the bundle's free parameters.
double relative_focal_sigma(const Bundle& bundle, const Eigen::MatrixXd& covariance);

// Refuses where the covariance that it holds has grown beyond what a focal length may have.
void judge_focal_length(Observability& seen, const Bundle& bundle);

SeenRegion seen_region(const Bundle& bundle);
double median_distance_m(const Bundle& bundle);  // of the corners from the camera

int num_corners(const Bundle& bundle);
int degrees_of_freedom(const Bundle& bundle);  // residuals less parameters and poses

}  // namespace tagcal::internal
