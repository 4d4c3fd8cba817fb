// Corners of a view as input of the pose, lists of points and pixels as a data set, and the
// camera's place in the target's frame.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "file_fixture.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

Vector6d place_of(const Pose& camera_from_target) {
  const CameraInTarget c = camera_in_target({.camera_from_target = camera_from_target});
  Vector6d v;
  v << c.position_m, c.azimuth_rad, c.elevation_rad, c.roll_rad;
  return v;
}

TEST(CameraInTarget, IsWhereTheCameraWasPut) {
  const Eigen::Vector3d eye(1, 2, 3);
  const double azimuth = 0.7, elevation = -0.3;
  const Eigen::Vector3d axis(std::cos(elevation) * std::cos(azimuth),
                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Pose level = camera_from_world_looking_at(eye, eye + axis, {0, 0, 1});
  // Clockwise as seen from behind: about the optical axis, from x to y of the camera.
  const double roll = 0.2;
  const Pose rolled = Pose(Eigen::Quaterniond(Eigen::AngleAxisd(-roll, Eigen::Vector3d::UnitZ())),
                           Eigen::Vector3d::Zero()) *
                      level;
  Vector6d expected;
  expected << eye, azimuth, elevation, roll;
  EXPECT_LT((place_of(rolled) - expected).norm(), 1e-12);
  // Behind it, the camera's right side (x) went down.
  const Eigen::Vector3d right = rolled.rotation_matrix().row(0);
  EXPECT_LT(right.z(), 0);
}

TEST(CameraInTarget, TheCovarianceIsThatOfTheDifferences) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d eye(random.normal(), random.normal(), random.normal());
    const Pose pose = camera_from_world_with_angles(
        {random.uniform(-3, 3), random.uniform(-1.4, 1.4), random.uniform(-3, 3)}, eye);
    Matrix6 root;
    for (double& x : root.reshaped()) x = random.normal();
    PoseHypothesis hypothesis{.camera_from_target = pose};
    hypothesis.covariance = root * root.transpose();
    const CameraInTarget camera = camera_in_target(hypothesis);
    Matrix6 numeric;
    constexpr double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
      Vector6d step = Vector6d::Zero();
      step[k] = h;
      Vector6d change = place_of(retract(pose, step)) - place_of(retract(pose, -step));
      for (int a = 3; a < 6; ++a) change[a] = std::remainder(change[a], 2 * std::numbers::pi);
      numeric.col(k) = change / (2 * h);
    }
    const Matrix6 expected = numeric * hypothesis.covariance * numeric.transpose();
    EXPECT_LT((camera.covariance - expected).norm(), 1e-6 * expected.norm());
    EXPECT_FALSE(camera.gimbal_lock);
  }
}

TEST(CameraInTarget, AngleThatIsNotDefinedHasNoCovariance) {
  const Pose above = camera_from_world_looking_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0});
  PoseHypothesis hypothesis{.camera_from_target = above};
  hypothesis.covariance = Matrix6::Identity();
  const CameraInTarget camera = camera_in_target(hypothesis);
  EXPECT_TRUE(camera.gimbal_lock);
  EXPECT_TRUE(std::isnan(camera.covariance(3, 3)));
  EXPECT_TRUE(std::isnan(camera.covariance(5, 5)));
  EXPECT_NEAR(camera.covariance(4, 4), 1, 1e-9);
  EXPECT_NEAR(camera.elevation_rad, -std::numbers::pi / 2, 1e-9);
}

// A board of one tag, 1 m to the right in the world, and a view of it and of a stranger.
struct Sight {
  std::vector<PlacedBoard> boards = {
      {make_board(AprilGrid{1, 1, 0.1, 0.3, 4, "tag36h11", 1, false}), translation({1, 0, 0})}};
  View view;

  Sight() {
    for (const TargetPoint& point : target_points(boards[0].board)) {
      const auto pixel =
          project(camera.lens, camera_from_world * (boards[0].world_from_board * point.position));
      view.observations.push_back({point.id, *pixel, {}});
    }
    view.observations.push_back({{99, 0}, {1, 1}, {}});
  }
  Camera camera{pinhole(600, 600, 319.5, 239.5), {640, 480}};
  Pose camera_from_world =
      camera_from_world_looking_at({1.2, -0.2, 0.5}, {1.05, 0.05, 0}, {0, 1, 0});
};

TEST(ViewCorrespondences, AreTheCornersOfTheBoardsInTheWorld) {
  const Sight sight;
  const ViewCorrespondences seen = view_correspondences(sight.view, sight.boards);
  ASSERT_EQ(seen.correspondences.size(), 4u);
  EXPECT_EQ(seen.ids[0], (CornerId{4, 0}));
  EXPECT_EQ(seen.correspondences[1].point, Eigen::Vector3d(1.1, 0, 0));
  EXPECT_EQ(seen.correspondences[1].pixel, sight.view.observations[1].pixel);
  EXPECT_EQ(seen.groups, (std::vector<int>{4, 4, 4, 4}));
  EXPECT_TRUE(seen.covariance_px2.empty());
  EXPECT_EQ(correspondences(sight.view, sight.boards).size(), 4u);
  const PoseEstimate pose = estimate_pose(seen, sight.camera, {.sigma_px = 0.1});
  ASSERT_TRUE(is_answer(pose.status));
  EXPECT_LT(distance_between_m(pose.camera_from_target(), sight.camera_from_world), 1e-6);
}

TEST(ViewCorrespondences, CovariancesNeedTheCamerasErrorAndYieldToAStatedNoise) {
  Sight sight;
  for (Observation& o : sight.view.observations) o.covariance_px2 = 0.04 * Matrix2::Identity();
  EXPECT_TRUE(view_correspondences(sight.view, sight.boards).covariance_px2.empty());
  const ViewCorrespondences seen = view_correspondences(sight.view, sight.boards, 0.1);
  ASSERT_EQ(seen.covariance_px2.size(), 4u);
  EXPECT_NEAR(seen.covariance_px2[0](0, 0), 0.05, 1e-15);
  EXPECT_EQ(seen.with_these().covariance_px2.size(), 4u);
  EXPECT_EQ(seen.with_these().groups.size(), 4u);
  EXPECT_TRUE(seen.with_these(PoseOptions{.sigma_px = 1}).covariance_px2.empty());
}

TEST(DatasetFromCorrespondences, HasEachPointOnce) {
  const Eigen::Vector3d a(0, 0, 0), b(0.1, 0, 0), c(0, 0.1, 0.02);
  const std::vector<std::vector<Correspondence>> views = {
      {{a, {1, 2}}, {b, {3, 4}}}, {{c, {5, 6}}, {b, {7, 8}}}, {}};
  const Dataset dataset = dataset_from_correspondences(views, {64, 48});
  EXPECT_EQ(dataset.image_size, (ImageSize{64, 48}));
  const auto points = points_in_world(dataset.boards);
  ASSERT_EQ(points.size(), 3);
  ASSERT_EQ(dataset.views.size(), 3);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto back = correspondences(dataset.views[v], dataset.boards);
    ASSERT_EQ(back.size(), views[v].size());
    for (std::size_t i = 0; i < back.size(); ++i) {
      EXPECT_EQ(back[i].point, views[v][i].point);
      EXPECT_EQ(back[i].pixel, views[v][i].pixel);
    }
  }
  EXPECT_EQ(dataset.views[0].observations[1].id, dataset.views[1].observations[1].id);
}

TEST(DatasetFromCorrespondences, RefusesRepeatedPointsAndNumbersThatAreNotFinite) {
  using Views = std::vector<std::vector<Correspondence>>;
  const Correspondence a{{0.1, 0, 0}, {1, 2}}, same{{0.1, -0.0, 0}, {3, 4}};
  const auto message = [](const Views& views) {
    return error_of([&] { dataset_from_correspondences(views, {64, 48}); });
  };
  EXPECT_EQ(message({{}, {a, same}}), "view 1: the point (0.1, -0, 0) occurs twice");
  EXPECT_EQ(message({{{{0, 0, 0}, {std::nan(""), 2}}}}),
            "view 0: points and pixels must be finite");
}

}  // namespace
}  // namespace tagcal
