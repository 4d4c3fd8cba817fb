#pragma once

#include <optional>

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// How well a plane's pose is known when it may as well face the camera.
//
// The tilt of a plane shows in its foreshortening, whose change with the tilt vanishes where the
// plane faces the line of sight, and in its perspective, which does not. Information that was
// computed at the tilt that noise left over claims too much: noise n in the foreshortening moves a
// frontal plane's tilt to sqrt(2 n), and there the linear standard deviation is half of the error
// that n stands for and less. Where the facing plane explains the view nearly as well (within 25
// sigma^2), the information is that of a smaller tilt. The standard deviation s of the tilt is then
// at least: what it spans itself, with information a(tilt) = a_0 + b tilt^2 in its direction
// s^2 = 1 / a(s); and so large that the facing plane and the mirrored one lie as many standard
// deviations away as their costs say.
//
// Where such a plane has only one minimum, but the linear covariance would exclude the mirrored
// tilt that its cost does not (within 9 sigma^2), the mirrored pose is a second hypothesis all the
// same.
struct FrontalPose {
  Eigen::Matrix<double, 6, 6> information;  // J'J for the covariance (upper triangle)
  std::optional<ViewSolution<6>> mirrored;  // of the least cost at its tilt, with that information
};

// Where the mirrored pose is a minimum of its own (`both_minima`), that one has its own covariance,
// and only the facing plane counts here.
//
// Precondition: the points are a plane's, in their own frame.
FrontalPose unless_frontal(ViewSums& sums, const ViewSolution<6>& solution, double sigma_px,
                           bool both_minima = false);

}  // namespace tagcal::internal
