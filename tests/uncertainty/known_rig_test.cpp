#include "tagcal/uncertainty/known_rig.hpp"

#include <gtest/gtest.h>

#include "tagcal/geometry/pose.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

// Two-sided p of a normal variable beyond 1.96, 3.29 sd: 0.05, 0.001. The quantiles of these,
// within the approximation of variance_ratio_score.
TEST(KnownRig, StepScoreIsANormalQuantile) {
  const MatrixX variance = MatrixX::Constant(1, 1, 4);
  EXPECT_NEAR(step_score(Eigen::VectorXd::Constant(1, 2 * 1.960), variance).value(), 1.645, 0.05);
  EXPECT_NEAR(step_score(Eigen::VectorXd::Constant(1, 2 * 3.291), variance).value(), 3.090, 0.05);
  // Chi-square of 3 degrees of freedom: 7.815 is exceeded with 0.05, 16.27 with 0.001.
  const Vector3d way = Vector3d(1, -2, 3).normalized(), sigmas(0.1, 2, 30);
  for (const auto& [square, quantile] : {std::pair(7.815, 1.645), std::pair(16.27, 3.090)}) {
    const Vector3d step = std::sqrt(square) * sigmas.cwiseProduct(way);
    const Eigen::Matrix3d covariance = sigmas.cwiseAbs2().asDiagonal();
    EXPECT_NEAR(step_score(step, covariance).value(), quantile, 0.05);
    const Eigen::Matrix3d turn = exp_rotation({0.4, -0.5, 0.7}).toRotationMatrix();
    EXPECT_NEAR(step_score(turn * step, turn * covariance * turn.transpose()).value(), quantile,
                0.05);
  }
}

TEST(KnownRig, StepScoreLeavesOutWhatHasNoVariance) {
  const Vector3d along = Vector3d(1, 1, 1).normalized();
  const Eigen::Matrix3d covariance = 4 * along * along.transpose();
  EXPECT_NEAR(step_score(2 * 1.960 * along, covariance).value(), 1.645, 0.05);
  EXPECT_FALSE(step_score(along, MatrixX::Zero(3, 3)));
}

}  // namespace
}  // namespace tagcal
