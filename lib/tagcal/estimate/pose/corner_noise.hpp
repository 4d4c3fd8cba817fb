#pragma once

#include <cstddef>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// px. The floor of the noise of a calibration's residuals: exact corners are exact to the solver's
// convergence, which must not choose between models.
constexpr double kLeastNoisePx = 1e-4;  // numeric: convergence

// Counts the corners that have a covariance of their own.
struct CornerNoise {
  std::size_t num_known = 0;
  std::size_t num_corners = 0;

  void add(const View& view);
  // True if half of the corners or more have a covariance: then the estimate uses them.
  bool counts() const { return num_known > 0 && 2 * num_known >= num_corners; }
  std::size_t num_assumed() const { return num_corners - num_known; }
};

// Returns a corner's own covariance, or that of policy::kAssumedSigmaPx.
Matrix2 covariance_or_assumed(const Observation& corner);

// Noise per coordinate by the residuals of views under a known camera: the sum of their squares,
// and six coordinates of each view that went into its pose. With fewer degrees of freedom than
// policy::kEnoughDegreesOfFreedom it is policy::kAssumedSigmaPx, and a finding says so.
double sigma_of_residuals(double square_px2, std::size_t num_corners, std::size_t num_views,
                          std::vector<Finding>& findings);

}  // namespace tagcal::internal
