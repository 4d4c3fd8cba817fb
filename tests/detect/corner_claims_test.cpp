// Every corner that detect() reports has a covariance, and lies within it: boards near a fisheye's
// rim, where lenses bend tags beyond what the fit of one tag allows for.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

Scene near_the_rim() {
  Scene scene;
  scene.camera = {Fisheye({226, 228, 315, 237, 0.02, -0.003, -0.005, 0.0005}), {640, 480}};
  scene.boards.push_back(
      {make_board(AprilGrid{6, 6, 0.088, 0.3, 0, "tag36h11", 1, false}), Pose()});
  DomePath path;
  path.target = {0.33, 0.33, 0};
  path.min_distance_m = 0.2;
  path.max_distance_m = 0.5;
  path.max_azimuth_rad = 6.28;
  path.min_elevation_rad = 0.8;
  path.max_elevation_rad = 1.5;
  scene.path = path;
  scene.jitter = {0.02, 0.25, 3};
  scene.num_views = 8;
  scene.sensor = {1, 0.8, 2};
  return scene;
}

TEST(CornerClaims, HoldWhereALensBendsTags) {
  const Scene scene = near_the_rim();
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  const auto points = points_in_world(scene.boards);
  const std::vector<Pose> poses = camera_poses(scene, 5);
  std::size_t corners = 0, beyond_4 = 0, read = 0;
  double squares = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Image8 picture =
        expose(render_light(scene, families, poses[i]), scene.sensor, Random(5, i).next());
    DetectOptions sides;
    sides.refinement = Refinement::edges;
    read += detect(picture, scene.boards, sides).view.observations.size();
    for (const Observation& seen : detect(picture, scene.boards).view.observations) {
      ASSERT_TRUE(seen.covariance_px2.has_value());
      const auto truth = project(scene.camera.lens, poses[i] * points.at(seen.id));
      ASSERT_TRUE(truth.has_value());
      const Eigen::Vector2d error = seen.pixel - *truth;
      const double size = error.dot(Eigen::Matrix2d(*seen.covariance_px2).inverse() * error);
      EXPECT_LT(size, 5 * 5) << i << " tag " << seen.id.tag_id;
      beyond_4 += size > 4 * 4;
      squares += size / 2;
      ++corners;
    }
  }
  EXPECT_GE(corners, 400u);
  EXPECT_GE(static_cast<double>(corners), 0.97 * static_cast<double>(read));
  EXPECT_LE(beyond_4, 2u);
  EXPECT_NEAR(squares / static_cast<double>(corners), 1, 0.15);
}

// Each corner of a tag has a covariance of its own: the near ones of a tilted tag are known better
// or worse than the far ones, and each scatters from picture to picture as it claims.
TEST(CornerClaims, OfEachCornerAreItsScatter) {
  Scene scene;
  scene.camera = {pinhole(300, 300, 159.5, 119.5), {320, 240}};
  const Tag tag{5, 0.1, Pose()};
  scene.boards.push_back({make_board(Tags{"tag36h11", 1, {tag}}), Pose()});
  scene.sensor = {1, 0.8, 4};
  const Pose pose =
      camera_from_world_looking_at({0.13, -0.1, 0.09}, {0.005, 0, 0}, Eigen::Vector3d::UnitZ());
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  const ImageF light = render_light(scene, families, pose);
  constexpr int kPictures = 150;
  std::array<Eigen::Matrix2d, 4> seen, claimed;
  std::array<Eigen::Vector2d, 4> truth;
  for (std::size_t k = 0; k < 4; ++k) {
    seen[k] = claimed[k] = Eigen::Matrix2d::Zero();
    truth[k] = project(scene.camera.lens, pose * tag_corners(tag)[k]).value();
  }
  for (std::uint64_t i = 0; i < kPictures; ++i) {
    DetectOptions options;
    options.camera = &scene.camera;  // else the claims allow for lenses that bend tags
    const View view = detect(expose(light, scene.sensor, i), scene.boards, options).view;
    ASSERT_EQ(view.observations.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d error = view.observations[k].pixel - truth[k];
      seen[k] += error * error.transpose() / kPictures;
      claimed[k] += Eigen::Matrix2d(view.observations[k].covariance_px2.value()) / kPictures;
    }
  }
  for (std::size_t k = 0; k < 4; ++k) {
    // 2 kPictures squares: their mean has a relative standard deviation of 8 %.
    EXPECT_NEAR((claimed[k].inverse() * seen[k]).trace() / 2, 1, 0.3) << k;
  }
}

}  // namespace
}  // namespace tagcal
