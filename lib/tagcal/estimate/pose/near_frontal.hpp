#pragma once

#include <optional>

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// Information of a plane's pose that may face the camera, and the mirrored pose if its minimum is
// missing.
//
// The tilt of a plane changes its foreshortening, to second order where the plane faces the line of
// sight, and its perspective, to first order. Noise n in the foreshortening moves the tilt of a
// frontal plane to sqrt(2 n), where the linear standard deviation is at most half of that error. If
// the cost of the facing plane exceeds that of the solution by at most policy::kExcludedCost, the
// information is therefore that of a smaller tilt: the standard deviation s of the tilt solves
// s^2 = 1 / a(s) for the information a(tilt) = a_0 + b tilt^2 along the tilt, and is large enough
// that the Mahalanobis distances of the facing and of the mirrored plane agree with their costs.
//
// If such a plane has only one minimum, and the linear covariance excludes the mirrored tilt but
// its cost does not (policy::kAmbiguousCost), the mirrored pose is a second hypothesis.
struct NearFrontalPose {
  Eigen::Matrix<double, 6, 6> information;  // J'J for the covariance (upper triangle)
  std::optional<PoseMinimum<6>> mirrored;   // of least cost at its tilt, with its information
};

// If the mirrored pose is a minimum of its own (`both_minima`), that minimum has its own
// covariance, and only the facing plane is considered.
//
// Precondition: the points lie in a plane and are given in its frame.
NearFrontalPose near_frontal_pose(ViewSums& sums, const PoseMinimum<6>& solution, double sigma_px,
                                  bool both_minima = false);

}  // namespace tagcal::internal
