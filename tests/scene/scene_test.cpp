#include <gtest/gtest.h>

#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

Scene scene_on(CameraPath path, int num_views) {
  return {.camera = {pinhole(500, 500, 319.5, 239.5), {640, 480}},
          .model = "pinhole",
          .path = std::move(path),
          .num_views = num_views};
}

Vector3d eye(const Pose& camera_from_world) { return camera_from_world.inverse().translation(); }

// How far the point is off the optical axis, and whether ahead.
double off_axis(const Pose& camera_from_world, const Vector3d& target) {
  const Vector3d x = camera_from_world * target;
  return x.z() > 0 ? x.head<2>().norm() : 1e9;
}

void expect_upright(const Pose& camera_from_world) {
  const Vector3d up_in_camera = camera_from_world.rotation() * Vector3d::UnitZ();
  EXPECT_NEAR(up_in_camera.x(), 0, 1e-12);
  EXPECT_LT(up_in_camera.y(), 0);
}

TEST(Path, RingStandsOnItsCircleAndEndsAtItsEnd) {
  const RingPath ring{{1, 2, 3}, 2, 0.5, 1.5, {0, 0, 1}};
  const auto poses = camera_poses(scene_on(ring, 5), 1);
  ASSERT_EQ(poses.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    const double angle = 0.5 + 0.25 * i;
    const Pose& pose = poses[static_cast<std::size_t>(i)];
    EXPECT_LT((eye(pose) - Vector3d(1 + 2 * std::cos(angle), 2 + 2 * std::sin(angle), 3)).norm(),
              1e-12);
    EXPECT_LT(off_axis(pose, {0, 0, 1}), 1e-12);
    expect_upright(pose);
  }
}

TEST(Path, FullRingDoesNotRepeatItsStart) {
  for (const double turn : {2 * kPi, -2 * kPi}) {
    const auto poses =
        camera_poses(scene_on(RingPath{{0, 0, 1}, 2, 0.3, 0.3 + turn, {0, 0, 0}}, 8), 1);
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_NEAR((eye(poses[i]) - eye(poses[(i + 1) % 8])).norm(), 4 * std::sin(kPi / 8), 1e-12);
  }
}

TEST(Path, DomeFillsItsRanges) {
  const DomePath dome{{1, 1, 0}, 0.5, 1.5, -0.5, 2.0, 0.3, 1.4};
  const int n = 200;
  const auto poses = camera_poses(scene_on(dome, n), 1);
  int counts[4][4] = {};
  double covariance = 0;
  for (int i = 0; i < n; ++i) {
    const Pose& pose = poses[static_cast<std::size_t>(i)];
    const Vector3d d = eye(pose) - Vector3d(1, 1, 0);
    const double azimuth = std::atan2(d.y(), d.x());
    const double sine = d.z() / d.norm();
    EXPECT_NEAR(d.norm(), 0.5 + static_cast<double>(i) / (n - 1), 1e-12);
    EXPECT_LT(off_axis(pose, {1, 1, 0}), 1e-12);
    expect_upright(pose);
    const double a = (azimuth + 0.5) / 2.5;
    const double e = (sine - std::sin(0.3)) / (std::sin(1.4) - std::sin(0.3));
    ASSERT_TRUE(a >= -1e-9 && a < 1 && e >= 0 && e < 1);
    ++counts[static_cast<int>(4 * std::max(a, 0.0))][static_cast<int>(4 * e)];
    covariance += (d.norm() - 1) * (e - 0.5) / n;
  }
  for (const auto& row : counts)
    for (const int count : row) EXPECT_NEAR(count, n / 16.0, 3);
  EXPECT_LT(std::abs(covariance), 0.1 / 12);  // correlation below 10 %
}

TEST(Path, DomeOfFewViews) {
  for (int n = 1; n <= 30; ++n)
    EXPECT_EQ(camera_poses(scene_on(DomePath{{0, 0, 0}, 1, 2, 0, 1, 0.5, 1}, n), 1).size(),
              static_cast<std::size_t>(n));
}

TEST(Path, LineRunsFromEndToEnd) {
  const auto poses = camera_poses(scene_on(LinePath{{1, 0, 0.5}, {3, 2, 0.5}, {0, 5, 0}}, 3), 1);
  EXPECT_LT((eye(poses[0]) - Vector3d(1, 0, 0.5)).norm(), 1e-12);
  EXPECT_LT((eye(poses[1]) - Vector3d(2, 1, 0.5)).norm(), 1e-12);
  EXPECT_LT((eye(poses[2]) - Vector3d(3, 2, 0.5)).norm(), 1e-12);
  for (const Pose& pose : poses) EXPECT_LT(off_axis(pose, {0, 5, 0}), 1e-12);
}

TEST(Path, StraightDownUpIsY) {
  const auto poses = camera_poses(scene_on(LinePath{{1, 1, 2}, {1, 1, 1}, {1, 1, 0}}, 2), 1);
  for (const Pose& pose : poses)
    EXPECT_LT((pose.rotation() * Vector3d::UnitY() - Vector3d(0, -1, 0)).norm(), 1e-12);
}

TEST(Path, ExplicitPosesAreKept) {
  const ExplicitPath path{{Pose(exp_rotation({0.1, 0.2, 0.3}), {1, 2, 3}),
                           Pose(exp_rotation({2.1, 0.2, 0.3}), {1, 0, 3})}};
  const auto poses = camera_poses(scene_on(path, 2), 1);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT(angle_between_rad(poses[i], path.camera_from_world[i]), 1e-12);
    EXPECT_LT(distance_between_m(poses[i], path.camera_from_world[i]), 1e-12);
  }
  EXPECT_THROW(camera_poses(scene_on(path, 3), 1), Error);
  EXPECT_THROW(camera_poses(scene_on(path, 0), 1), Error);
}

TEST(Path, JitterIsSeededPerViewAndBounded) {
  const LinePath line{{1, 0, 0.5}, {3, 2, 0.5}, {0, 5, 0}};
  const Scene still = scene_on(line, 40);
  Scene moved = still;
  moved.jitter = {0.05, 0.02, 0.3};
  const auto path = camera_poses(still, 1);
  const auto a = camera_poses(moved, 1);
  const auto b = camera_poses(moved, 1);
  const auto c = camera_poses(moved, 2);
  double largest_shift = 0;
  double largest_roll = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(a[i].matrix(), b[i].matrix());
    EXPECT_GT(distance_between_m(a[i], c[i]), 1e-6);
    const double shift = (eye(a[i]) - eye(path[i])).cwiseAbs().maxCoeff();
    EXPECT_LE(shift, 0.05 + 1e-12);
    const Vector3d up = a[i].rotation() * Vector3d::UnitZ();
    const double roll = std::abs(std::atan2(up.x(), -up.y()));
    EXPECT_LE(roll, 0.3 + 1e-12);
    largest_shift = std::max(largest_shift, shift);
    largest_roll = std::max(largest_roll, roll);
    // The target moved by at most 0.02 a coordinate.
    EXPECT_LE(off_axis(a[i], {0, 5, 0}), 0.02 * std::sqrt(3.0));
    EXPECT_GT(off_axis(a[i], {0, 5, 0}), 1e-9);
  }
  EXPECT_GT(largest_shift, 0.04);
  EXPECT_GT(largest_roll, 0.25);
}

TEST(Path, JitterOfAnExplicitPathLooksOneMetreAhead) {
  Scene scene = scene_on(ExplicitPath{{Pose(exp_rotation({0.1, 0.2, 0.3}), {1, 2, 3})}}, 1);
  scene.jitter.position_m = 0.05;
  const Pose given = std::get<ExplicitPath>(scene.path).camera_from_world[0];
  const Pose moved = camera_poses(scene, 3)[0];
  EXPECT_GT((eye(moved) - eye(given)).norm(), 1e-3);
  EXPECT_LT(off_axis(moved, given.inverse() * Vector3d(0, 0, 1)), 1e-12);
}

TEST(Path, ImageNames) {
  EXPECT_EQ(image_name(0), "000.png");
  EXPECT_EQ(image_name(42), "042.png");
  EXPECT_EQ(image_name(1234), "1234.png");
}

}  // namespace
}  // namespace tagcal
