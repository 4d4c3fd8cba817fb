#pragma once

#include <span>
#include <vector>

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// Returns the poses of a fit in the target's frame, with covariances and probabilities by
// likelihood. Poses with singular information are dropped. The covariance is widened
// (widened_covariance). `covariance` becomes that of (omega, tau, log f) of the first pose.
template <int N>
std::vector<PoseHypothesis> hypotheses_of(
    const PoseProblem& problem, const Lens& lens, const PoseMinima<N>& fit,
    Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance = nullptr);

// A linear covariance is trusted where the variance of the least known turn is at most this times
// the standard deviation of the best known one (radians).
constexpr double kCurved = 0.2;  // numeric: saves time, the profile of others widens nothing

// The covariance of (omega, tau), widened by the profile likelihood of the least known turns
// (profile_likelihood.hpp), if these are so uncertain that the linear covariance may be too small:
// half of the variance of a turn, its second-order effect, is compared with the standard deviation
// of the best known turn. `points` are those of the sums.
Eigen::Matrix<double, 6, 6> widened_covariance(ViewSums& sums,
                                               std::span<const Eigen::Vector3d> points,
                                               double sigma_px, const PoseMinimum<6>& pose,
                                               const Eigen::Matrix<double, 6, 6>& covariance);

// The same of (omega, tau, log f), by the profile towards shorter focal lengths: noise determines
// the tilt of a plane that nearly faces the camera, and with a smaller tilt the focal length is
// shorter and less certain. (Weak perspective is tested for longer ones.) Not widened for a focal
// length that is known to policy::kFocalWellKnown, and for one that is refused anyway.
Eigen::Matrix<double, 7, 7> widened_covariance(ViewSums& sums,
                                               std::span<const Eigen::Vector3d> points,
                                               double sigma_px, const PoseMinimum<7>& pose,
                                               const Eigen::Matrix<double, 7, 7>& covariance);

}  // namespace tagcal::internal
