#pragma once

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// The poses of a view that are told apart: the minima that a fit found, and those beside them.
using PosesOfView = Solutions<ViewSolution<6>, 8>;

// Whether two poses are one, of which the solver stopped at two places.
bool is_one(const ViewSolution<6>& a, const ViewSolution<6>& b, double sigma_px);

// Whether the least known turn is known so badly that a linear covariance may claim too much: its
// variance, half of which is what a turn changes in second order, against the standard deviation of
// the best known turn.
bool may_be_curved(const Eigen::Matrix<double, 6, 6>& covariance);

// What a linear covariance of (omega, tau) leaves out of the likelihood.
//
// Where a turn is hardly known, all that goes with it does so along a curve: a tilt by an angle a
// changes the scale by a^2 / 2, which may be many of its own standard deviations; and the cost may
// rise by less than the squared number of them, or fall towards another minimum. So from the pose,
// along the least known turns, by four standard deviations to each side and further while the cost
// hardly rises, the cost is minimised over all else (profile likelihood: Venzon & Moolgavkar,
// Applied Statistics 1988). Each pose that this leads to, by a step e to a cost that is p sigma^2
// higher, is let into the ellipsoid at sqrt(p): where the covariance has it at m = e' C^-1 e > p,
// it gains (1 / p - 1 / m) e e'.
class PoseProfile {
 public:
  // They must outlive it. A minimum that is met on the way, within kAmbiguousCost of the first of
  // the poses, is appended to them.
  PoseProfile(ViewSums& sums, double sigma_px, PosesOfView& poses);

  // The gain of a pose's covariance.
  Eigen::Matrix<double, 6, 6> gain(const ViewSolution<6>& pose,
                                   const Eigen::Matrix<double, 6, 6>& covariance);

  // What it gains by the curve alone, from one pose in each direction: for planes whose flatness
  // and second minimum are known (frontal.hpp), at a tenth of the time.
  Eigen::Matrix<double, 6, 6> gain_of_curve(const ViewSolution<6>& pose,
                                            const Eigen::Matrix<double, 6, 6>& covariance);

 private:
  struct Walk {
    Walk(const ViewSolution<6>& from, const Eigen::Matrix<double, 6, 6>& covariance,
         const Vector6d& direction);

    const ViewSolution<6>& from;
    const Eigen::Matrix<double, 6, 6>& covariance;
    Vector6d direction;  // a linear function of the turn, with a standard deviation of 1
    Vector6d step;       // the likeliest one with a value of 1, if the covariance is right
    double longest;      // in standard deviations
  };
  bool is_curved(const Walk& walk);
  void go(const Walk& walk, double side, Eigen::Matrix<double, 6, 6>& gain);
  void keep_minimum_near(const ViewState& state);

  ViewSums& sums_;
  double sigma_px_;
  PosesOfView& poses_;
};

}  // namespace tagcal::internal
