#pragma once

#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

namespace tagcal::internal {

// Returns the matrix to add to the linear covariance C of (omega, tau, log f) of a plane that
// nearly faces the camera.
//
// Noise determines the estimated tilt of such a plane. With a smaller tilt the focal length is
// shorter and less certain, so that towards shorter focal lengths the cost rises by less than the
// squared number of standard deviations. The cost is therefore minimised over all poses at a focal
// length that is five standard deviations shorter (profile likelihood: Venzon & Moolgavkar, Applied
// Statistics 1988). If the step e there raises the cost by p sigma^2, but m = e' C^-1 e > p, adding
// (1 / p - 1 / m) e e' to C gives e the Mahalanobis distance sqrt(p). Zero for other targets, for a
// focal length that is known to 3 %, and for one that is refused anyway.
Eigen::Matrix<double, 7, 7> shorter_focal_widening(const PoseProblem& problem, const Lens& pinhole,
                                                   const PoseMinimum<7>& solution,
                                                   const Eigen::Matrix<double, 7, 7>& covariance,
                                                   double sigma_px);

}  // namespace tagcal::internal
