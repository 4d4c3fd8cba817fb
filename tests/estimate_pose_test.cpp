#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "tagcal/estimate/closed_form.hpp"
#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Camera kCamera{opencv5_lens(), {1280, 800}};

std::vector<Correspondence> seen(const std::vector<Vector3d>& points, const Pose& pose,
                                 double sigma_px, Random& random) {
  std::vector<Correspondence> result;
  for (const Vector3d& p : points)
    result.push_back({p, *project(kCamera.lens, pose * p) +
                             sigma_px * Vector2d(random.normal(), random.normal())});
  return result;
}

std::vector<Vector3d> tag(double size) {
  const auto corners = tag_corners({0, size, Pose()});
  return {corners.begin(), corners.end()};
}

TEST(EstimatePose, IsExactWithoutNoise) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.2, 1.0), 0.6, random);
    const PoseEstimate e = estimate_pose(seen(tag(0.1), pose, 0, random), kCamera);
    ASSERT_TRUE(is_answer(e.status)) << i;
    EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-7) << i;
    EXPECT_LT(distance_between_m(e.camera_from_target(), pose), 1e-7) << i;
  }
}

TEST(EstimatePose, IsExactWhereOthersFail) {
  Random random(2);
  // Exactly frontal, turned by 180 degrees, tiny and huge targets, far from the origin.
  for (const double unit : {1e-6, 1.0, 1e6}) {
    for (const double tilt : {0.0, 1e-9, 0.5}) {
      const Pose pose = looking_at_board(Vector3d::Zero(), tilt, 0.6 * unit, random);
      const PoseEstimate e = estimate_pose(seen(tag(0.1 * unit), pose, 0, random), kCamera);
      ASSERT_TRUE(is_answer(e.status)) << unit << " " << tilt;
      EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-4) << unit << " " << tilt;
      EXPECT_LT(distance_between_m(e.camera_from_target(), pose), 1e-6 * unit);
    }
  }
}

TEST(EstimatePose, CovarianceIsThatOfTheErrors) {
  Random random(3);
  std::vector<Vector3d> board;
  for (const TargetPoint& p : target_points(usual_board())) board.push_back(p.position);
  for (const auto& points : {tag(0.2), board}) {
    double sum = 0;
    constexpr int kTrials = 400;
    for (int i = 0; i < kTrials; ++i) {
      const Pose pose =
          looking_at_board(points.size() > 4 ? Vector3d(0.33, 0.33, 0) : Vector3d::Zero(),
                           random.uniform(0.5, 0.8), 1.0, random);
      const PoseEstimate e = estimate_pose(seen(points, pose, 0.2, random), kCamera, {0.2, 50});
      ASSERT_TRUE(is_answer(e.status));
      const Vector6d error = minus(e.camera_from_target(), pose);
      sum += error.dot(Eigen::MatrixXd(e.hypotheses.front().covariance).ldlt().solve(error));
    }
    EXPECT_NEAR(sum / (6 * kTrials), 1, 0.12);  // sd 0.029
  }
}

TEST(EstimatePose, AFarTagIsAmbiguousAndTheTruthIsAmongTheTwo) {
  Random random(4);
  int ambiguous = 0, missed = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 2.5, random);
    const PoseEstimate e = estimate_pose(seen(tag(0.088), pose, 0.5, random), kCamera, {0.5, 50});
    ASSERT_TRUE(is_answer(e.status));
    ambiguous += e.status == Status::ambiguous;
    double nearest = 10, sum = 0;
    for (const PoseHypothesis& h : e.hypotheses) {
      nearest = std::min(nearest, angle_between_rad(h.camera_from_target, pose));
      sum += h.probability;
    }
    missed += nearest > 0.4;
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  EXPECT_GT(ambiguous, 120);
  EXPECT_LE(missed, 2);
}

TEST(EstimatePose, PointsInSpace) {
  Random random(5);
  std::vector<Vector3d> points;
  for (int i = 0; i < 20; ++i)
    points.emplace_back(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                        random.uniform(-0.2, 0.2));
  for (int i = 0; i < 100; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0, 3.1), 1.5, random);
    const PoseEstimate e = estimate_pose(seen(points, pose, 0, random), kCamera);
    ASSERT_EQ(e.status, Status::ok);
    EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-7);
  }
}

TEST(EstimatePose, NamesWhatCannotBeSolved) {
  Random random(6);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.4, 1, random);
  const std::vector<Vector3d> line = {
      {0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.05, 0, 0}, {0.15, 0, 0}};
  EXPECT_EQ(estimate_pose(seen(line, pose, 0.1, random), kCamera).status, Status::degenerate);
  auto three = seen(tag(0.1), pose, 0, random);
  three.pop_back();
  EXPECT_EQ(estimate_pose(three, kCamera).status, Status::degenerate);
  EXPECT_EQ(estimate_pose({}, kCamera).status, Status::degenerate);
  auto nan = seen(tag(0.1), pose, 0, random);
  nan[2].pixel.x() = std::nan("");
  EXPECT_EQ(estimate_pose(nan, kCamera).status, Status::degenerate);
  const std::vector<Vector3d> same(5, Vector3d(0.1, 0.2, 0));
  EXPECT_EQ(estimate_pose(seen(same, pose, 0.1, random), kCamera).status, Status::degenerate);
}

TEST(ClosedForm, HomographyIsExactForFourPoints) {
  Eigen::Matrix3d h;
  h << 1, 0.2, 0.1, -0.1, 0.9, 0.3, 0.05, -0.1, 1;
  const std::vector<Vector2d> points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  std::vector<Vector3d> rays;
  for (const Vector2d& p : points) rays.push_back(h * p.homogeneous());
  const Eigen::Matrix3d found = *homography(points, rays);
  EXPECT_LT((found / found.norm() - h / h.norm()).norm(), 1e-13);
  const std::vector<Vector2d> line = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
  EXPECT_FALSE(homography(line, rays).has_value());
}

TEST(ClosedForm, FocalLengthFromPlanes) {
  Random random(7);
  std::vector<Eigen::Matrix3d> homographies;
  for (int i = 0; i < 5; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1, random);
    Eigen::Matrix3d h;
    h << pose.rotation_matrix().leftCols<2>(), pose.translation();
    homographies.emplace_back(Vector3d(1.7, 1.7, 1).asDiagonal() * h);
  }
  EXPECT_NEAR(*focal_ratio_from_homographies(homographies), 1.7, 1e-12);
}

}  // namespace
}  // namespace tagcal
