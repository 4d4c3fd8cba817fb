#pragma once

#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

namespace tagcal::internal {

// What the linear covariance of (omega, tau, log f) leaves out of the likelihood where a plane
// nearly faces the camera.
//
// Its tilt is what noise made of it, and with less tilt the focal length is shorter and held worse:
// towards shorter ones the cost rises by less than the squared number of standard deviations. So
// at the focal length that is five of them shorter the cost is minimised over all poses (profile
// likelihood: Venzon & Moolgavkar, Applied Statistics 1988), and that step e, to a cost that is p
// sigma^2 higher, is let into the ellipsoid at sqrt(p): where the covariance has it at
// m = e' C^-1 e > p, it gains (1 / p - 1 / m) e e'. Zero for other targets, for a focal length that
// is known to 3 %, and for one that is refused all the same.
Eigen::Matrix<double, 7, 7> gain_towards_shorter(const PoseProblem& problem, const Lens& pinhole,
                                                 const ViewSolution<7>& solution,
                                                 const Eigen::Matrix<double, 7, 7>& covariance,
                                                 double sigma_px);

}  // namespace tagcal::internal
