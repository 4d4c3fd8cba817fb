#pragma once

#include "tagcal/estimate/bundle/covariance.hpp"

namespace tagcal::internal {

// The covariance of a bundle's parameters (all), widened by the profile likelihood
// (profile_likelihood.hpp) of the least known of focal length and principal point, to either side.
// Focal length, principal point and poses are correlated along a curve, a bent valley of the cost,
// of which the information describes the tangent only. Not widened if the parameters are well
// determined (policy::kLinearShare).
Eigen::MatrixXd profile_covariance(const Bundle& solved, const BundleInformation& information,
                                   const Eigen::MatrixXd& covariance, double sigma);

}  // namespace tagcal::internal
