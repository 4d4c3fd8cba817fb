#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {

// The least-squares fit of the inliers, or the reason why there is none.
template <int N>
struct RobustPose {
  std::optional<PoseProblem> problem;  // of the inliers
  std::optional<PoseMinima<N>> fit;
  ResidualTest residuals = ResidualTest::inconsistent;  // of the inliers, by the stated noise
  std::vector<std::size_t> outliers;                    // ascending
  bool model_error = false;       // the residuals are correlated: a finding says so
  std::vector<Finding> findings;  // without a fit the last one is the reason

  // The best minimum. Precondition: there is a fit.
  Pose camera_from_target() const {
    return pose_of(fit->best().state) * problem->spread().plane_from_target_pose();
  }
};

// Fits all correspondences; if their residuals are inconsistent, searches for the inliers (RANSAC).
// Inliers whose residuals contradict the stated or assumed noise (chi-square beyond
// policy::kSignificant) raise it, and a finding says so: inliers, minima, odds, covariance and
// status are all of the raised noise. Residuals beyond policy::kOutlierSigmas times a stated noise
// are refused: no_consensus.
template <int N>
RobustPose<N> fit_pose_robustly(std::span<const Correspondence> correspondences, const Lens& lens,
                                const PoseOptions& options);

}  // namespace tagcal::internal
