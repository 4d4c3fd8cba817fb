#pragma once

#include <vector>

#include "tagcal/estimate/pose/pose_minima.hpp"

namespace tagcal::internal {

// The poses of a fit in the target's frame, with covariances and odds by likelihood; without those
// that the points do not fix. A plane that may as well face the camera is as uncertain as that
// makes it (frontal.hpp). `covariance` becomes that of the first one's (omega, tau, log f).
template <int N>
std::vector<PoseHypothesis> hypotheses_of(
    const PoseProblem& problem, const Lens& lens, const ViewFit<N>& fit,
    Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance = nullptr);

extern template std::vector<PoseHypothesis> hypotheses_of<6>(const PoseProblem&, const Lens&,
                                                             const ViewFit<6>&, Matrix6*);
extern template std::vector<PoseHypothesis> hypotheses_of<7>(const PoseProblem&, const Lens&,
                                                             const ViewFit<7>&, Matrix7*);

}  // namespace tagcal::internal
