#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// Compares the solutions of two halves of the views (every other view, and the rest), each one
// Gauss-Newton step from the common solution. The projections are compared at `samples` and at the
// distance. Returns no value for fewer than six views, or if a half does not determine the
// parameters.
std::optional<HalvesCheck> split_half_check(const Bundle& solved,
                                            const BundleInformation& information, double sigma,
                                            std::span<const Eigen::Vector2d> samples,
                                            double distance_m);

}  // namespace tagcal::internal
