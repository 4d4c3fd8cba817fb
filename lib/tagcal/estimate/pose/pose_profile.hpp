#pragma once

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// The distinct poses of a view: the minima that a fit found, and those that a profile found.
using PosesOfView = Solutions<PoseMinimum<6>, 8>;

// True if two poses are one minimum, at which the solver stopped twice.
bool is_same_minimum(const PoseMinimum<6>& a, const PoseMinimum<6>& b, double sigma_px);

// True if the least known turn is so uncertain that a linear covariance may be too small: half of
// its variance, the second-order effect of the turn, is compared with the standard deviation of the
// best known turn.
bool may_be_curved(const Eigen::Matrix<double, 6, 6>& covariance);

// Widens the linear covariance C of (omega, tau) by the profile likelihood.
//
// The other parameters depend on a turn by a curve: a tilt by an angle a changes the scale by
// a^2 / 2, which may be many standard deviations of the scale if the tilt is uncertain. The cost
// may also rise by less than the squared number of standard deviations, or fall towards another
// minimum. The profile therefore steps from the pose along the least known turns, by four standard
// deviations to each side and further while the cost hardly rises, and minimises the cost over the
// other parameters (Venzon & Moolgavkar, Applied Statistics 1988). If a step e raises the cost by p
// sigma^2, but m = e' C^-1 e > p, adding (1 / p - 1 / m) e e' to C gives e the Mahalanobis distance
// sqrt(p).
class PoseProfile {
 public:
  // The arguments must outlive it. A minimum that a profile finds within policy::kAmbiguousCost of
  // the first of the poses is appended to them.
  PoseProfile(ViewSums& sums, double sigma_px, PosesOfView& poses);

  // Returns the matrix to add to the covariance of a pose.
  Eigen::Matrix<double, 6, 6> widening(const PoseMinimum<6>& pose,
                                       const Eigen::Matrix<double, 6, 6>& covariance);

  // The same by the curvature alone, from one pose in each direction, at a tenth of the time. For
  // planes whose flat likelihood and second minimum near_frontal.hpp has treated.
  Eigen::Matrix<double, 6, 6> curvature_widening(const PoseMinimum<6>& pose,
                                                 const Eigen::Matrix<double, 6, 6>& covariance);

 private:
  // A path from a pose along one direction.
  struct Path {
    Path(const PoseMinimum<6>& from, const Eigen::Matrix<double, 6, 6>& covariance,
         const Vector6d& direction);

    const PoseMinimum<6>& from;
    const Eigen::Matrix<double, 6, 6>& covariance;
    Vector6d direction;  // a linear function of the turn, with a standard deviation of 1
    Vector6d step;       // the most likely step with a value of 1 by the covariance
    double longest;      // in standard deviations
  };
  bool is_curved(const Path& path);
  void follow(const Path& path, double side, Eigen::Matrix<double, 6, 6>& widening);
  void keep_minimum_near(const ViewState& state);

  ViewSums& sums_;
  double sigma_px_;
  PosesOfView& poses_;
};

}  // namespace tagcal::internal
