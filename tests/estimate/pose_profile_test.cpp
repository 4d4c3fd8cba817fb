#include "tagcal/estimate/pose/pose_hypotheses.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "study/tasks/pose_tasks.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal {
using namespace study;
using namespace internal;
namespace {

using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kSigmaPx = 0.5, kVariance = kSigmaPx * kSigmaPx;

// A view and its best pose, about the centre of the points.
struct ProfiledView {
  ProfiledView(const std::vector<Vector3d>& points, Random& random)
      : task(draw_task(points, {}, random)),
        options{kSigmaPx},
        problem(task.correspondences, options),
        sums(task.camera.lens, problem.view()),
        fit(pose_minima<6>(problem, task.camera.lens, options).value()) {
    SmallCholesky<6> cholesky;
    EXPECT_TRUE(cholesky.compute(fit.best().information));
    linear = kVariance * cholesky.inverse();
  }

  Matrix6d widened() {
    return widened_covariance(sums, problem.view().points, kSigmaPx, fit.best(), linear);
  }

  PoseTask task;
  PoseOptions options;
  PoseProblem problem;
  ViewSums sums;
  PoseMinima<6> fit;
  Matrix6d linear;
};

// Four random points in a square, as in a trial of map points.
ProfiledView quadrangle(std::uint64_t trial) {
  Random random(1, (std::uint64_t{2} << 32) + trial);
  std::vector<Vector3d> points = space_points(4, 1, random);
  for (Vector3d& p : points) p = p.cwiseProduct(Vector3d(0.6, 0.6, 0));
  return {points, random};
}

// Share of the posterior that is further than 5 sigma from the best pose, by a random walk
// (Metropolis et al. 1953).
double share_outside(ProfiledView& view, const Matrix6d& covariance) {
  constexpr int kSteps = 20000;
  Random random(7);
  const Matrix6d root = covariance.llt().matrixL();
  const Matrix6d information = covariance.inverse();
  const Pose best = pose_of(view.fit.best().state);
  Pose pose = best;
  double cost = view.fit.best().cost;
  int outside = 0;
  for (int i = 0; i < kSteps; ++i) {
    Vector6d noise;
    for (double& x : noise) x = 0.5 * random.normal();
    const Pose next = retract(pose, root * noise);
    NormalEquations<6> there;
    const bool seen = view.sums.at(state_of(next), there);
    if (seen && random.uniform() < std::exp((cost - there.cost) / (2 * kVariance)))
      pose = next, cost = there.cost;
    const Vector6d step = minus(pose, best);
    outside += step.dot(information * step) > 39.5;  // 5 sigma of six dimensions
  }
  return static_cast<double>(outside) / kSteps;
}

TEST(PoseProfile, TheEllipsoidHoldsTheLikelihood) {
  for (const std::uint64_t trial : {239u, 465u, 1058u}) {
    ProfiledView view = quadrangle(trial);
    EXPECT_GT(share_outside(view, view.linear), 0.02) << trial;
    EXPECT_LT(share_outside(view, view.widened()), 0.002) << trial;
  }
}

TEST(PoseProfile, DoesNotWidenAParabola) {
  Random random(3);
  ProfiledView view(space_points(30, 0.6, random), random);
  EXPECT_EQ(view.widened(), view.linear);
}

TEST(PoseProfile, NearbyMinimaAreOne) {
  Random random(3);
  const ProfiledView view(square_points(0.088), random);
  PoseMinimum<6> beside = view.fit.best();
  beside.state.translation.z() += 0.01 * std::sqrt(view.linear(5, 5));
  EXPECT_TRUE(is_same_minimum(view.fit.best(), beside, kSigmaPx));
  beside.state.translation.z() += 20 * std::sqrt(view.linear(5, 5));
  EXPECT_FALSE(is_same_minimum(view.fit.best(), beside, kSigmaPx));
}

}  // namespace
}  // namespace tagcal
