#include <gtest/gtest.h>

#include <vector>

#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Camera kOutlierCamera{opencv5_lens(), {1280, 800}};

std::vector<Correspondence> observed(const std::vector<Vector3d>& points, const Pose& pose,
                                     double sigma_px, Random& random) {
  return seen_by(kOutlierCamera.lens, points, pose, sigma_px, random);
}

// Moves a share of the corners, single ones or whole tags, to random places; returns which.
std::vector<std::size_t> spoil(std::vector<Correspondence>& corners, double share, bool whole_tags,
                               Random& random) {
  std::vector<std::size_t> spoilt;
  for (std::size_t k = 0; k < corners.size(); k += whole_tags ? 4 : 1) {
    if (random.uniform() >= share) continue;
    const Vector2d offset(random.uniform(40, 300), random.uniform(-300, 300));
    for (std::size_t j = k; j < k + (whole_tags ? 4 : 1); ++j) {
      corners[j].pixel += offset;
      spoilt.push_back(j);
    }
  }
  return spoilt;
}

TEST(EstimatePose, OutliersAreListedWhateverIsKnownOfTheNoise) {
  Random random(36);
  std::vector<int> ids;
  for (int k = 0; k < 144; ++k) ids.push_back(k / 4);
  const std::vector<Matrix2> covariances(144, 0.09 * Matrix2::Identity());
  for (const double share : {0.01, 0.05, 0.2, 0.5, 0.7})
    for (const bool whole_tags : {false, true})
      for (const PoseOptions& options : {PoseOptions{.sigma_px = 0.3}, PoseOptions{},
                                         PoseOptions{.sigma_px = 0.3, .groups = ids},
                                         PoseOptions{.covariance_px2 = covariances}}) {
        const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 1.2, random);
        auto corners = observed(board_points(), pose, 0.3, random);
        const auto spoilt = spoil(corners, share, whole_tags, random);
        const PoseEstimate e = estimate_pose(corners, kOutlierCamera, options);
        ASSERT_EQ(e.status, Status::ok) << share << whole_tags;
        EXPECT_EQ(e.outliers, spoilt) << share << whole_tags;
        EXPECT_LT(normalised_squared_error(e.hypotheses.front(), pose), 40);
        EXPECT_LT(e.hypotheses.front().rms_px, 0.6);
      }
}

TEST(EstimatePose, AnOutlierOfTenSigmaIsOne) {
  Random random(43);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 1.2, random);
    auto corners = observed(board_points(), pose, 0.3, random);
    const std::size_t k = random.index(corners.size());
    corners[k].pixel += Vector2d(3, 3);
    for (const double sigma : {0.3, 0.0}) {
      const PoseEstimate e = estimate_pose(corners, kOutlierCamera, {.sigma_px = sigma});
      ASSERT_EQ(e.status, Status::ok);
      EXPECT_EQ(e.outliers, std::vector<std::size_t>{k}) << sigma;
    }
  }
}

// Near tags of a wide lens have larger noise than others. Their corners raise the noise that the
// residuals show, and are beyond what its median allows: some are rejected, and there is a pose.
TEST(EstimatePose, UnevenNoiseIsNoReasonForNoPose) {
  Random random(44);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 1.2, random);
    std::vector<Correspondence> corners = observed(board_points(), pose, 0.05, random);
    corners.resize(52);
    for (std::size_t k = 0; k < 10; ++k)
      corners[k].pixel += 0.2 * Vector2d(random.normal(), random.normal());
    const PoseEstimate e = estimate_pose(corners, kOutlierCamera);
    ASSERT_EQ(e.status, Status::ok) << i;
    for (const std::size_t k : e.outliers) EXPECT_LT(k, 10u) << i;
    EXPECT_LT(normalised_squared_error(e.hypotheses.front(), pose), 60) << i;
  }
}

TEST(EstimatePose, OutliersMayStay) {
  Random random(37);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 1.2, random);
  auto corners = observed(board_points(), pose, 0.3, random);
  corners[17].pixel.x() += 60;
  const PoseEstimate e =
      estimate_pose(corners, kOutlierCamera, {.sigma_px = 0.3, .reject_outliers = false});
  EXPECT_EQ(e.status, Status::no_consensus);
  EXPECT_TRUE(e.hypotheses.empty());
  corners[17].pixel.x() += 1e9;
  EXPECT_EQ(estimate_pose(corners, kOutlierCamera).outliers, std::vector<std::size_t>{17});
}

TEST(EstimatePose, PixelsWithoutNoiseAreNoOutliers) {
  Random random(38);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), i % 2 == 0 ? 0 : 0.5, 1.2, random);
    const Camera camera{i % 4 < 2 ? centred_pinhole(900) : kOutlierCamera.lens, {1280, 800}};
    const PoseEstimate e =
        estimate_pose(seen_by(camera.lens, board_points(), pose, 0, random), camera);
    ASSERT_EQ(e.status, Status::ok) << i;
    EXPECT_TRUE(e.outliers.empty()) << i;
    EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-7) << i;
  }
}

// Random corners in the image, and with them some extremely distant ones.
TEST(EstimatePose, RandomDataHaveNoConsensus) {
  Random random(39);
  for (const std::size_t n : {8u, 40u})
    for (const double far : {0.0, 1e9, 1e300})
      for (const double sigma : {0.0, 0.5}) {
        std::vector<Correspondence> noise;
        for (const Vector3d& p : board_points())
          if (noise.size() < n)
            noise.push_back({p, {random.uniform(0, 1280), random.uniform(0, 800)}});
        if (far > 0) noise[3].pixel.setConstant(far);
        const PoseEstimate e = estimate_pose(noise, kOutlierCamera, {.sigma_px = sigma});
        EXPECT_FALSE(is_answer(e.status)) << n << " " << far << " " << sigma;
        EXPECT_EQ(e.status, Status::no_consensus) << n << " " << far << " " << sigma;
      }
}

TEST(EstimatePose, EqualSeedsGiveEqualAnswers) {
  Random random(42);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 1.2, random);
  auto corners = observed(board_points(), pose, 0.3, random);
  spoil(corners, 0.6, false, random);
  const PoseEstimate a = estimate_pose(corners, kOutlierCamera, {.seed = 7});
  const PoseEstimate b = estimate_pose(corners, kOutlierCamera, {.seed = 7});
  const PoseEstimate c = estimate_pose(corners, kOutlierCamera, {.seed = 8});
  ASSERT_EQ(a.status, Status::ok);
  EXPECT_EQ(a.camera_from_target().matrix(), b.camera_from_target().matrix());
  EXPECT_EQ(a.outliers, b.outliers);
  EXPECT_EQ(a.outliers, c.outliers);
  EXPECT_LT(angle_between_rad(a.camera_from_target(), c.camera_from_target()), 1e-6);
}

}  // namespace
}  // namespace tagcal
