#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// The test of whether the data determine a lens, by the standard deviations that are printed: those
// of the focal length and of the projection at infinity. Single coefficients are not judged.
struct Observability {
  Status status = Status::ok;  // or degenerate, focal_not_observable, not_observable
  std::string reason;          // a sentence, if the status is not ok
  double focal_share = 0;      // sd(f) / f
  double projection_px = 0;    // standard deviation of the projection at infinity, RMS over corners
};

// `covariance`: the claim about the bundle's lens, by the parameters of `model`.
Observability observability(const Bundle& bundle, const Model& model,
                            const Eigen::MatrixXd& covariance);

// `solve`, and where it runs out of iterations, further rounds of `max_iterations`, until the
// solver converges, or until a round lowers the cost by less than a hundredth of the noise's
// variance for each parameter: along correlated coefficients the cost has a long flat valley in
// which no corner moves. `converged` is true then, too.
BundleSummary solve_until_converged(Bundle& bundle, int max_iterations, std::size_t num_threads);

SeenRegion seen_region(const Bundle& bundle);
double median_distance_m(const Bundle& bundle);         // from the camera to the corners
std::vector<double> distances_m(const Bundle& bundle);  // of each view, to its corners' centroid

int num_corners(const Bundle& bundle);
int degrees_of_freedom(const Bundle& bundle);  // number of residuals - parameters - 6 per pose

// The same poses, with the lens in the parameters of another model.
Bundle with_model(const Bundle& bundle, const Model& model);

}  // namespace tagcal::internal
