#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/estimate/bundle/covariance.hpp"

namespace tagcal::internal {

// Covariance of weakly determined parameters, widened by the profile likelihood (Venzon &
// Moolgavkar, Applied Statistics 1988). Focal length, principal point and poses are correlated
// along a curve, a bent valley of the cost. The information describes its tangent only, and
// predicts a rise of t^2 sigma^2 at t standard deviations, from which the true rise differs.
//
// The profile of the least known of focal length and principal point is followed to two standard
// deviations on either side. The covariance is widened
//   - along the tangent, by the factor by which the cost rises more slowly than predicted, and
//   - by 3 d d' for the distance d of the profile from the tangent on either side, so that five
//     standard deviations contain the curve about that far.
// `information` is that of the solved bundle, `covariance` that of its parameters for noise of
// `sigma`. No value if the parameters are well determined (policy::kLinearShare), or if the profile
// leaves the domain of the lens.
std::optional<Eigen::MatrixXd> profile_covariance(const Bundle& solved,
                                                  const BundleInformation& information,
                                                  const Eigen::MatrixXd& covariance, double sigma);

}  // namespace tagcal::internal
