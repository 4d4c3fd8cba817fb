#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// Every other view against the rest, by one Gauss-Newton step of each from their common solution.
// `samples` and the distance are where projections are compared. No value for fewer than six views,
// or where a half does not hold the parameters.
std::optional<HalvesCheck> compare_halves(const Bundle& solved,
                                          const BundleInformation& information, double sigma,
                                          std::span<const Eigen::Vector2d> samples,
                                          double distance_m);

}  // namespace tagcal::internal
