#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/estimate/bundle/covariance.hpp"

namespace tagcal::internal {

// Parameters that are weakly held lie in a valley of the cost that bends: focal length, principal
// point and poses trade along a curve, of which the information knows the tangent only, and rises
// to its sides more slowly, or faster, than d^2 sigma^2 at d standard deviations.
//
// The valley of the focal length or coordinate of the principal point that is known least is
// followed to two of its standard deviations on either side (the profile likelihood: Venzon &
// Moolgavkar, Applied Statistics 1988), and the covariance widened
//   - along it, by how much slower the cost rises there, and
//   - towards where it lies beside its tangent, by d: with 3 d d' of either side, so that the
//     ellipsoid of five standard deviations holds the valley as far as it reaches.
// `information`: of the solved bundle, `covariance` of its parameters for noise of `sigma`. No
// value where everything is held well (to 1 % of the focal length) or there is no valley to follow.
std::optional<Eigen::MatrixXd> widened_along_valley(const Bundle& solved,
                                                    const BundleInformation& information,
                                                    const Eigen::MatrixXd& covariance,
                                                    double sigma);

}  // namespace tagcal::internal
