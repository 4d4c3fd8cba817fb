#pragma once

#include <vector>

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// Returns the poses of a fit in the target's frame, with covariances and probabilities by
// likelihood. Poses with singular information are dropped. pose_profile.hpp widens the covariance
// where the linear one is too small. `covariance` becomes that of (omega, tau, log f) of the first
// pose.
template <int N>
std::vector<PoseHypothesis> hypotheses_of(
    const PoseProblem& problem, const Lens& lens, const PoseMinima<N>& fit,
    Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance = nullptr);

extern template std::vector<PoseHypothesis> hypotheses_of<6>(const PoseProblem&, const Lens&,
                                                             const PoseMinima<6>&, Matrix6*);
extern template std::vector<PoseHypothesis> hypotheses_of<7>(const PoseProblem&, const Lens&,
                                                             const PoseMinima<7>&, Matrix7*);

}  // namespace tagcal::internal
