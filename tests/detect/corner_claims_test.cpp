// Every corner that detect() reports has a covariance, and lies within it: boards near a fisheye's
// rim, where lenses bend tags beyond what the fit of one tag allows for.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

Scene near_the_rim() {
  Scene scene;
  scene.camera = {Fisheye({226, 228, 315, 237, 0.02, -0.003, -0.005, 0.0005}), {640, 480}};
  scene.boards.push_back({grid_board({6, 6, 0.088, 0.3, 0}, "tag36h11", 1, false), Pose()});
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
    read += detect(picture, "", scene.boards, sides, nullptr).observations.size();
    for (const Observation& seen : detect(picture, "", scene.boards, {}, nullptr).observations) {
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

}  // namespace
}  // namespace tagcal
