#include "tagcal/scene/viewing.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "tagcal/error.hpp"
#include "tagcal/random.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A tag on a wall 4 m away, seen through a doorway, another beside it; by hand in
// docs/course/viewing.md.
Scene doorway() {
  const auto rectangle = [](double left, double right, double low, double high) {
    return Occluder{{{left, 2, low}, {right, 2, low}, {right, 2, high}, {left, 2, high}}, 0.5};
  };
  const auto board = [](int id, double x) {
    const Board tag = make_board(Tags{.tags = {{id, 0.4, Pose()}}});
    return PlacedBoard{tag, Pose(exp_rotation({M_PI / 2, 0, 0}), {x, 4, 1.2})};
  };
  Scene scene;
  scene.camera = {pinhole(500, 500, 319.5, 239.5), {640, 480}};
  scene.boards = {board(0, 0.2), board(1, 1.6)};
  scene.occluders = {rectangle(-2, -0.5, 0, 2.6), rectangle(0.5, 2, 0, 2.6),
                     rectangle(-0.5, 0.5, 2, 2.6)};
  return scene;
}

// At a height of 1 m, looking along +y.
const Pose kLooking(exp_rotation({M_PI / 2, 0, 0}), {0, 1, 0});

FollowedPoint follow(const Scene& scene, const NamedPoint& point, const Pose& pose = kLooking) {
  return followed(point, scene, viewing_pipeline(scene.camera, pose, 1, 10));
}

TEST(Viewing, FollowsThePointThatIsWorkedByHand) {
  const Scene scene = doorway();
  const FollowedPoint f = follow(scene, named_corner(scene, {0, 2}).value());
  EXPECT_EQ(f.in_board, Vector3d(0.2, 0.2, 0));
  EXPECT_TRUE(f.in_world.isApprox(Vector3d(0.4, 4, 1.4), 1e-15));
  EXPECT_TRUE(f.in_camera.isApprox(Vector3d(0.4, -0.4, 4), 1e-15));
  EXPECT_TRUE(f.in_eye.isApprox(Vector3d(0.4, 0.4, -4), 1e-15));
  EXPECT_TRUE(f.in_clip.isApprox(Eigen::Vector4d(0.4 / 0.64, 0.4 / 0.48, 24.0 / 9, 4), 1e-14));
  EXPECT_TRUE(f.in_volume);
  EXPECT_TRUE(f.in_ndc->isApprox(Vector3d(0.1 / 0.64, 0.1 / 0.48, 6.0 / 9), 1e-14));
  EXPECT_TRUE(f.in_raster_px->isApprox(Vector2d(369.5, 189.5), 1e-14));
  EXPECT_TRUE(f.pixel->isApprox(Vector2d(369.5, 189.5), 1e-14));
  EXPECT_EQ(f.sight, Sight::seen);
  // Half of all depth values are spent before this.
  EXPECT_NEAR(z_from_opengl_depth(0, 1, 10), -2 / (1 + 1.0 / 10), 1e-15);
  EXPECT_NEAR(z_from_opengl_depth(0, 1, 10), -1.818, 5e-4);
}

TEST(Viewing, SaysWhyAPointIsNotSeen) {
  const Scene scene = doorway();
  const auto at = [&](const Vector3d& x) { return follow(scene, {"here", {}, x, {}}); };
  EXPECT_EQ(follow(scene, named_corner(scene, {1, 0}).value()).sight, Sight::hidden);
  EXPECT_EQ(at({0, 3, 1}).sight, Sight::seen);
  EXPECT_EQ(at({1, 3, 1}).sight, Sight::hidden);
  EXPECT_EQ(at({2, 1, 1}).sight, Sight::outside_image);
  const FollowedPoint behind = at({0, -1, 1});
  EXPECT_EQ(behind.sight, Sight::outside_domain);
  EXPECT_FALSE(behind.in_volume);
  EXPECT_FALSE(behind.in_ndc || behind.in_raster_px || behind.pixel);
  EXPECT_FALSE(at({0, 0.5, 1}).in_volume);  // before the near plane

  // From the other side of the tags' wall, looking back.
  const Pose back = Pose(exp_rotation({0, M_PI, 0}), {0, 0, 5.5}) * kLooking;
  EXPECT_EQ(follow(scene, named_corner(scene, {0, 2}).value(), back).sight, Sight::turned_away);
}

TEST(Viewing, KnowsOnlyTheCornersOfTheScene) {
  EXPECT_FALSE(named_corner(doorway(), {2, 0}));
  EXPECT_FALSE(named_corner(doorway(), {0, 4}));
  EXPECT_EQ(named_corner(doorway(), {1, 3})->name, "tag 1 corner 3");
}

TEST(Viewing, EnclosesWhatIsInFront) {
  const NearFar planes = enclosing_planes(doorway(), kLooking);
  EXPECT_NEAR(planes.near_m, 1, 1e-12);
  EXPECT_NEAR(planes.far_m, 8, 1e-12);
  const Pose away = Pose(exp_rotation({0, M_PI, 0}), Vector3d::Zero()) * kLooking;
  EXPECT_EQ(enclosing_planes(doorway(), away).near_m, 0.1);
}

// World -> camera -> eye -> clip -> NDC -> raster, step by step, against one call of OpenCV.
TEST(Viewing, TheWholeChainAgreesWithOpenCv) {
  Random random(1);
  double worst = 0;
  const auto coordinate = [&] { return random.uniform(-1, 1); };
  for (int i = 0; i < 10000; ++i) {
    Scene scene;
    const double f = random.uniform(200, 3000);
    const Perspective lens =
        pinhole(f, f * random.uniform(0.8, 1.2), random.uniform(0, 1280), random.uniform(0, 800));
    scene.camera = {lens, {1280, 800}};
    const Vector3d turn = 3 * Vector3d(coordinate(), coordinate(), coordinate());
    const Pose pose(exp_rotation(turn), 5 * Vector3d(coordinate(), coordinate(), coordinate()));
    const Vector3d x_in_camera = random.uniform(1, 9) * Vector3d(coordinate(), coordinate(), 1);
    const NamedPoint point{"point", {}, pose.inverse() * x_in_camera, {}};
    const FollowedPoint step_by_step = follow(scene, point, pose);

    const cv::Mat k = (cv::Mat_<double>(3, 3) << lens.parameters()[0], 0, lens.parameters()[2], 0,
                       lens.parameters()[1], lens.parameters()[3], 0, 0, 1);
    const Vector3d r = log_rotation(pose.rotation()), t = pose.translation();
    const std::vector<cv::Point3d> x = {
        {point.position.x(), point.position.y(), point.position.z()}};
    std::vector<cv::Point2d> pixel;
    cv::projectPoints(x, cv::Vec3d(r.x(), r.y(), r.z()), cv::Vec3d(t.x(), t.y(), t.z()), k,
                      cv::noArray(), pixel);
    const Vector2d difference = *step_by_step.in_raster_px - Vector2d(pixel[0].x, pixel[0].y);
    worst = std::max(worst, difference.norm());
  }
  EXPECT_LT(worst, 1e-9);
}

TEST(Viewing, TheLensMovesThePointThatTheMatricesCannot) {
  Scene scene = doorway();
  scene.camera.lens = Perspective({500, 500, 319.5, 239.5, -0.3, 0, 0, 0, 0, 0, 0, 0});
  const FollowedPoint f = follow(scene, named_corner(scene, {0, 2}).value());
  EXPECT_TRUE(f.in_raster_px->isApprox(Vector2d(369.5, 189.5), 1e-14));
  const double shrink = 1 - 0.3 * (0.01 + 0.01);
  EXPECT_TRUE(f.pixel->isApprox(Vector2d(319.5 + 50 * shrink, 239.5 - 50 * shrink), 1e-14));
}

TEST(Viewing, ParallelRaysHaveABox) {
  Scene scene = doorway();
  scene.camera.lens = Parallel({100, 100, 319.5, 239.5});
  const FollowedPoint f = follow(scene, {"point", {}, {0.4, 4, 1.4}, {}});
  EXPECT_EQ(f.in_clip.w(), 1);
  EXPECT_TRUE(f.pixel->isApprox(Vector2d(359.5, 199.5), 1e-14));
  EXPECT_TRUE(f.in_raster_px->isApprox(*f.pixel, 1e-14));
}

}  // namespace
}  // namespace tagcal
