#include "tagcal/estimate/pose/refine_pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <string>
#include <vector>

#include "view_fixture.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Reference: Gauss-Newton on all rows, from close to the minimum.
struct Reference {
  Pose pose;
  double focal_px, cost;
};
Reference reference(const Observed& o, double focal_px) {
  Reference at{o.pose, focal_px, 0};
  for (int i = 0; i < 12; ++i) {
    const VectorXd step = differences(o, at.pose, at.focal_px)
                              .colPivHouseholderQr()
                              .solve(-residuals(o, at.pose, at.focal_px));
    at.pose = retract(at.pose, step.head<6>());
    if (focal_px > 0) at.focal_px *= std::exp(step[6]);
  }
  at.cost = residuals(o, at.pose, at.focal_px).squaredNorm();
  return at;
}

Observed world(const Lens& lens, const std::vector<Vector3d>& points, const Pose& pose,
               double sigma_px, Random& random) {
  Observed o{lens, {}, {}, {}, pose};
  for (const Correspondence& c : seen_by(lens, points, pose, sigma_px, random)) {
    o.points.push_back(c.point);
    o.pixels.push_back(c.pixel);
  }
  return o;
}

template <int N>
std::optional<PoseMinimum<N>> solve_from(const Observed& o, const Pose& start, double focal_px,
                                         const RefineOptions& options = {}) {
  ViewSums sums(o.lens, o.view());
  InitialPose<N> at{state_of(start, focal_px), {}};
  if (!sums.at(at.state, at.equations)) return std::nullopt;
  return refine_pose<N>(sums, at, options);
}

// Moves a pose by up to so many radians and so much of its distance.
Pose away(const Pose& pose, double angle, double share, Random& random) {
  Vector6d step;
  for (int k = 0; k < 6; ++k) step[k] = random.uniform(-1, 1);
  step.head<3>() *= angle;
  step.tail<3>() *= share * pose.translation().norm();
  return retract(pose, step);
}

TEST(RefinePose, EndsAtTheMinimumOfADenseSolve) {
  Random random(7);
  const std::vector<Vector3d> space = points_in_box(10, 0.2, 1, random);
  for (const Lens& lens : {opencv5_lens(), fisheye_lens(), centred_pinhole(900)})
    for (const auto& points : {tag_points(0.3), board_points(), space})
      for (const double sigma : {0.0, 0.1, 1.0}) {
        const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.5, 0.9), 1, random);
        const Observed o = world(lens, points, pose, sigma, random);
        const Reference best = reference(o, 0);
        const auto found = solve_from<6>(o, away(pose, 0.05, 0.05, random), 0);
        ASSERT_TRUE(found && found->converged) << points.size() << " " << sigma;
        EXPECT_LT(angle_between_rad(pose_of(found->state), best.pose), 1e-4 * sigma + 1e-9);
        EXPECT_LT(distance_between_m(pose_of(found->state), best.pose), 1e-4 * sigma + 1e-9);
        EXPECT_NEAR(found->cost, best.cost, 1e-6 * best.cost + 1e-18);
        const MatrixXd j = differences(o, best.pose, 0);
        const Eigen::MatrixXd information = found->information.selfadjointView<Eigen::Upper>();
        EXPECT_LT((information - j.transpose() * j).norm(), 1e-3 * information.norm());
      }
}

TEST(RefinePose, WithTheFocalLengthToo) {
  Random random(8);
  const std::vector<Vector3d> space = points_in_box(10, 0.3, 1, random);
  for (const auto& points : {tag_points(0.5), board_points(), space})
    for (const double sigma : {0.0, 0.1, 1.0}) {
      const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.6, 0.9), 1, random);
      const Observed o = world(centred_pinhole(900), points, pose, sigma, random);
      const Reference best = reference(o, 900);
      const auto found = solve_from<7>(o, away(pose, 0.03, 0.03, random), 870);
      ASSERT_TRUE(found && found->converged) << points.size() << " " << sigma;
      EXPECT_LT(angle_between_rad(pose_of(found->state), best.pose), 1e-4 * sigma + 1e-9);
      EXPECT_NEAR(found->state.focal_px / best.focal_px, 1, 1e-4 * sigma + 1e-9);
      EXPECT_NEAR(found->cost, best.cost, 1e-6 * best.cost + 1e-18);
    }
}

TEST(RefinePose, ReachesTheMinimumFromFar) {
  Random random(9);
  int reached = 0, reached_with_focal = 0, started = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.3, 0.9), 1.2, random);
    const Observed o = world(centred_pinhole(900), board_points(), pose, 0.3, random);
    const Pose start = away(pose, 0.4, 0.2, random);
    const auto found = solve_from<6>(o, start, 0);
    if (!found) continue;
    ++started;
    reached += angle_between_rad(pose_of(found->state), pose) < 0.01 && found->converged;
    const auto focal = solve_from<7>(o, start, 900 * std::exp(random.uniform(-0.5, 0.5)));
    reached_with_focal +=
        focal && focal->converged && std::abs(std::log(focal->state.focal_px / 900)) < 0.2;
  }
  EXPECT_GT(started, 150);
  EXPECT_GE(reached, started * 98 / 100);
  EXPECT_GE(reached_with_focal, started * 95 / 100);
}

TEST(RefinePose, ReportsThatItDidNotConverge) {
  Random random(10);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1.2, random);
  const Observed o = world(centred_pinhole(900), board_points(), pose, 0.3, random);
  const Pose start = away(pose, 0.2, 0.1, random);
  for (const int iterations : {0, 1}) {
    const auto found = solve_from<6>(o, start, 0, {.max_iterations = iterations});
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->converged) << iterations;
    EXPECT_TRUE(found->state.rotation.allFinite());
  }
  EXPECT_TRUE(solve_from<6>(o, start, 0)->converged);
}

// A second hypothesis whose minimum lies above the limit is given up, one below it is not.
TEST(RefinePose, RulesOutMinimaAboveTheLimit) {
  Random random(11);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1.2, random);
    const Observed o = world(centred_pinhole(900), board_points(), pose, 0.3, random);
    const double least = solve_from<6>(o, pose, 0)->cost;
    EXPECT_FALSE(solve_from<6>(o, pose, 0, {.ruled_out_cost = 0.8 * least}));
    EXPECT_TRUE(solve_from<6>(o, pose, 0, {.ruled_out_cost = 1.01 * least}));
  }
}

// Points that do not determine a pose give a singular minimum, not NaN.
TEST(RefinePose, SurvivesSingularProblems) {
  Random random(12);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1.2, random);
    const std::vector<Vector3d> points(i % 2 == 0 ? 1 : 5, Vector3d(0.1, 0.05, 0));
    const Observed o = world(centred_pinhole(900), points, pose, 0.3, random);
    const auto six = solve_from<6>(o, away(pose, 0.1, 0.1, random), 0);
    const auto seven = solve_from<7>(o, away(pose, 0.1, 0.1, random), 800);
    ASSERT_TRUE(six && seven);
    EXPECT_TRUE(six->state.rotation.allFinite() && six->state.translation.allFinite());
    EXPECT_TRUE(seven->state.rotation.allFinite() && seven->state.focal_px > 0);
    EXPECT_TRUE(std::isfinite(six->cost) && std::isfinite(seven->cost));
  }
}

}  // namespace
}  // namespace tagcal
