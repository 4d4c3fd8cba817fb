#include "tagcal/estimate/pose/pose_hypotheses.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "study/tasks/pose_tasks.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal {
using namespace study;
using namespace internal;
namespace {

using Matrix7d = Eigen::Matrix<double, 7, 7>;

// A board of 36 corners, 0.66 m wide, from 1.2 m, on the axis.
PoseTask board_task(double tilt_deg, double sigma_px, Random& random) {
  ViewRange range{tilt_deg, tilt_deg, 1.2, 1.2, sigma_px};
  range.aside = false;
  return draw_task(tag_grid_points(3), range, random);
}

struct SolvedView {
  explicit SolvedView(const PoseTask& from)
      : task(from),
        options{from.sigma_px},
        problem(task.correspondences, options),
        fit(pose_minima<7>(problem, task.camera.lens, options).value()) {
    SmallCholesky<7> cholesky;
    EXPECT_TRUE(cholesky.compute(fit.best().information));
    linear = from.sigma_px * from.sigma_px * cholesky.inverse();
  }

  Matrix7d widening() const {
    ViewSums sums(task.camera.lens, problem.view());
    return widened_covariance(sums, problem.view().points, task.sigma_px, fit.best(), linear) -
           linear;
  }

  PoseTask task;
  PoseOptions options;
  PoseProblem problem;
  PoseMinima<7> fit;
  Matrix7d linear;
};

// The Mahalanobis distance of the pose at a shorter focal length agrees with its cost.
TEST(FocalProfile, TheEllipsoidHoldsTheLikelihood) {
  Random random(1);
  int widened = 0;
  for (int i = 0; i < 50; ++i) {
    const SolvedView view(board_task(2, 0.05, random));
    const double sigma = std::sqrt(view.linear(6, 6));
    const Matrix7d widening = view.widening();
    if (widening.isZero(0)) continue;
    ++widened;
    const double focal_px = view.fit.best().state.focal_px * std::exp(-5 * sigma);
    const Lens shorter = pinhole(focal_px, focal_px, 639.5, 399.5);
    const auto there = pose_minima<6>(view.problem, shorter, view.options);
    ASSERT_TRUE(there);
    Eigen::Matrix<double, 7, 1> step;
    step << minus(pose_of(there->best().state), pose_of(view.fit.best().state)), -5 * sigma;
    const double variance = view.task.sigma_px * view.task.sigma_px;
    const double rise = (there->best().cost - view.fit.best().cost) / variance;
    const double distance_square = step.dot(Matrix7d(view.linear + widening).ldlt().solve(step));
    EXPECT_LT(rise, 25) << i;
    EXPECT_NEAR(distance_square / rise, 1, 0.02) << i;
  }
  EXPECT_GT(widened, 40);
}

TEST(FocalProfile, DoesNotWidenAKnownFocalLength) {
  Random random(2);
  for (const double tilt_deg : {20.0, 45.0})
    EXPECT_TRUE(SolvedView(board_task(tilt_deg, 0.5, random)).widening().isZero(0)) << tilt_deg;
  EXPECT_TRUE(SolvedView(board_task(2, 0.001, random)).widening().isZero(0));
}

// Views (of 3,000 each) whose tilt is noise: the linear covariance gives 6 % for a focal length
// that is wrong by 30 %.
TEST(FocalProfile, ClaimsLittleForAPlaneTiltedByNoise) {
  for (const auto& [seed, trial] : {std::pair(2, 1351), {3, 954}, {4, 1696}}) {
    Random random(static_cast<std::uint64_t>(seed),
                  (std::uint64_t{13} << 32) + static_cast<std::uint64_t>(trial));
    const PoseTask task = board_task(2, 0.1, random);
    const auto estimate = estimate_pose_and_focal(task.correspondences, task.camera.image_size,
                                                  {.exact_pinhole = true});
    if (!is_answer(estimate.status)) continue;
    const double focal_px = parameters(task.camera.lens)[0];
    EXPECT_LT(std::abs(estimate.focal_px - focal_px), 4 * estimate.sigma_focal_px) << seed;
  }
}

}  // namespace
}  // namespace tagcal
