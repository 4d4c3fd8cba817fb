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

// Tags of 150 to 380 px: a part about a corner of theirs does not tell where their borders are from
// where the corner is, and a lens estimated from some of them is not that of the others.
Scene close_by() {
  Scene scene;
  scene.camera = {Perspective({827, 828, 785, 620, -0.068, 0.019, -0.0008, -0.00035, 0.005}),
                  {1600, 1200}};
  scene.boards.push_back({make_board(AprilGrid{6, 4, 0.03, 0.3, 0, "tag36h11", 1, false}), Pose()});
  DomePath path;
  path.target = {0.11, 0.07, 0};
  path.min_distance_m = 0.07;
  path.max_distance_m = 0.17;
  path.max_azimuth_rad = 6.28;
  path.min_elevation_rad = 1;
  path.max_elevation_rad = 1.57;
  scene.path = path;
  scene.jitter = {0.004, 0.02, 3};
  scene.num_views = 4;
  scene.sensor = {1, 0.7, 0.6};
  return scene;
}

struct Claims {
  std::size_t corners = 0, beyond_4 = 0, beyond_5 = 0;
  std::size_t by_sides = 0;  // corners that are found without a fit of the pattern
  double squares = 0;        // of errors over claims, sum of the mean of both coordinates
  double worst_px = 0;
};

Claims claims_of(const Scene& scene) {
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  const auto points = points_in_world(scene.boards);
  const std::vector<Pose> poses = camera_poses(scene, 5);
  Claims claims;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Image8 picture =
        expose(render_light(scene, families, poses[i]), scene.sensor, Random(5, i).next());
    DetectOptions sides;
    sides.refinement = Refinement::edges;
    claims.by_sides += detect(picture, scene.boards, sides).view.observations.size();
    for (const Observation& seen : detect(picture, scene.boards).view.observations) {
      const auto truth = project(scene.camera.lens, poses[i] * points.at(seen.id));
      const Eigen::Vector2d error = seen.pixel - truth.value();
      const double size = error.dot(Eigen::Matrix2d(seen.covariance_px2.value()).inverse() * error);
      claims.beyond_4 += size > 4 * 4;
      claims.beyond_5 += size > 5 * 5;
      claims.squares += size / 2;
      claims.worst_px = std::max(claims.worst_px, error.norm());
      ++claims.corners;
    }
  }
  return claims;
}

TEST(CornerClaims, HoldWhereALensBendsTags) {
  const Claims claims = claims_of(near_the_rim());
  EXPECT_GE(claims.corners, 400u);
  EXPECT_GE(static_cast<double>(claims.corners), 0.97 * static_cast<double>(claims.by_sides));
  EXPECT_LE(claims.beyond_4, 2u);
  EXPECT_EQ(claims.beyond_5, 0u);
  EXPECT_NEAR(claims.squares / static_cast<double>(claims.corners), 1, 0.15);
}

// A lamp near the board shades each tag: what the fit takes out of the levels is no noise.
TEST(CornerClaims, HoldUnderALamp) {
  Scene scene = near_the_rim();
  scene.light = Light{0.2, PointLamp{{0.1, 0.1, 0.35}, 0.1}};
  const Claims claims = claims_of(scene);
  EXPECT_GE(claims.corners, 300u);
  EXPECT_NEAR(claims.squares / static_cast<double>(claims.corners), 1, 0.25);
}

TEST(CornerClaims, HoldOfLargeTags) {
  const Claims claims = claims_of(close_by());
  EXPECT_GE(claims.corners, 150u);
  EXPECT_LE(claims.beyond_5, 1u);
  EXPECT_LT(claims.worst_px, 0.06);
  EXPECT_LT(claims.squares / static_cast<double>(claims.corners), 1.3);
}

// Each corner of a tag has a covariance of its own: the near ones of a tilted tag are known better
// or worse than the far ones, and each scatters from picture to picture as it claims.
void expect_scatter_as_claimed(const Sensor& sensor, int num_pictures, double tolerance) {
  Scene scene;
  scene.camera = {pinhole(300, 300, 159.5, 119.5), {320, 240}};
  const Tag tag{5, 0.1, Pose()};
  scene.boards.push_back({make_board(Tags{"tag36h11", 1, {tag}}), Pose()});
  scene.sensor = sensor;
  const Pose pose =
      camera_from_world_looking_at({0.13, -0.1, 0.09}, {0.005, 0, 0}, Eigen::Vector3d::UnitZ());
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  const ImageF light = render_light(scene, families, pose);
  std::array<Eigen::Matrix2d, 4> seen, claimed;
  std::array<Eigen::Vector2d, 4> truth;
  for (std::size_t k = 0; k < 4; ++k) {
    seen[k] = claimed[k] = Eigen::Matrix2d::Zero();
    truth[k] = project(scene.camera.lens, pose * tag_corners(tag)[k]).value();
  }
  for (int i = 0; i < num_pictures; ++i) {
    DetectOptions options;
    options.camera = &scene.camera;  // else the claims allow for lenses that bend tags
    const auto seed = static_cast<std::uint64_t>(i);
    const View view = detect(expose(light, scene.sensor, seed), scene.boards, options).view;
    ASSERT_EQ(view.observations.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d error = view.observations[k].pixel - truth[k];
      seen[k] += error * error.transpose() / num_pictures;
      claimed[k] += Eigen::Matrix2d(view.observations[k].covariance_px2.value()) / num_pictures;
    }
  }
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR((claimed[k].inverse() * seen[k]).trace() / 2, 1, tolerance) << k;
}

TEST(CornerClaims, OfEachCornerAreItsScatter) {
  // 300 squares: their mean has a relative standard deviation of 8 %.
  expect_scatter_as_claimed({1, 0.8, 4}, 150, 0.3);
}

// Colours that are interpolated from their neighbours' share their noise.
TEST(CornerClaims, CountNoiseThatNeighboursShare) {
  Sensor sensor{1, 0.8, 4};
  sensor.mosaic.emplace();
  expect_scatter_as_claimed(sensor, 60, 0.4);
}

}  // namespace
}  // namespace tagcal
