#include <gtest/gtest.h>

#include <ctime>

#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kRolledSize{96, 64};

// A board before a camera that turns and moves by several pixels while it is read.
Scene moving_scene(ReadDirection direction = ReadDirection::down) {
  Scene scene;
  scene.camera = {Perspective({90, 91, 47, 31, -0.1, 0.02}), kRolledSize};
  scene.boards = {{make_board(AprilGrid{3, 2, 0.2, 0.3, 0}), translation({-0.35, -0.2, 1})}};
  scene.sensor.blur_px = 0.6;
  scene.sensor.shutter = {0.03, direction};
  scene.velocity = {{0.4, -0.9, 1.5}, {0.5, -0.3, 0.8}};
  return scene;
}

const Pose kFacing = rotation_about_x(std::numbers::pi) * translation({0, 0, -2});

TEST(RollingShutter, EachLineIsThatLineFromItsOwnPose) {
  const TagFamilies families = tag_families(moving_scene().boards);
  for (const auto direction :
       {ReadDirection::down, ReadDirection::up, ReadDirection::right, ReadDirection::left}) {
    const Scene scene = moving_scene(direction);
    const ImageF rolling = render_light(scene, families, kFacing);
    const bool by_rows = scene.sensor.shutter.by_rows();
    const int lines = by_rows ? kRolledSize.height : kRolledSize.width;
    Scene still = scene;
    still.velocity = {};
    for (const int line : {0, lines / 3, lines / 2, lines - 1}) {
      const double place = (line + 0.5) / lines - 0.5;
      const bool forwards = direction == ReadDirection::down || direction == ReadDirection::right;
      const Pose pose = moved_for(forwards ? 0.03 * place : -0.03 * place, scene.velocity, kFacing);
      const ImageF whole = render_light(still, families, pose);
      for (int i = 0; i < (by_rows ? kRolledSize.width : kRolledSize.height); ++i) {
        const int x = by_rows ? i : line, y = by_rows ? line : i;
        EXPECT_NEAR(rolling(x, y), whole(x, y), 1e-4) << x << " " << y;
      }
    }
  }
}

TEST(RollingShutter, ACornerIsWhereThePoseOfItsLineHasIt) {
  for (const auto direction :
       {ReadDirection::down, ReadDirection::up, ReadDirection::right, ReadDirection::left}) {
    const Scene scene = moving_scene(direction);
    const auto points = points_in_world(scene.boards);
    const auto corners = visible_corners(scene, kFacing);
    EXPECT_EQ(corners.size(), points.size());
    double largest = 0;
    for (const Observation& o : corners) {
      const double seconds = scene.sensor.shutter.seconds_at(o.pixel, kRolledSize);
      const Pose pose = moved_for(seconds, scene.velocity, kFacing);
      const auto pixel = project(scene.camera.lens, pose * points.at(o.id));
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - o.pixel).norm(), 1e-10);
      const auto middle = project(scene.camera.lens, kFacing * points.at(o.id));
      largest = std::max(largest, (*middle - o.pixel).norm());
    }
    EXPECT_GT(largest, 0.5);
  }
}

TEST(RollingShutter, TheMiddleOfThePictureIsReadAtThePoseOfTheView) {
  const RollingShutter down{0.02};
  EXPECT_NEAR(down.seconds_at({7, 31.5}, kRolledSize), 0, 1e-15);
  EXPECT_NEAR(down.seconds_at({7, -0.5}, kRolledSize), -0.01, 1e-15);
  EXPECT_NEAR((RollingShutter{0.02, ReadDirection::left}.seconds_at({-0.5, 3}, kRolledSize)), 0.01,
              1e-15);
}

TEST(RollingShutter, WithoutMotionOrReadoutThePicturesHaveTheSameBytes) {
  Scene global = moving_scene();
  const TagFamilies families = tag_families(global.boards);
  global.sensor.shutter = {};
  global.velocity = {};
  const ImageF expected = render_light(global, families, kFacing);
  Scene still = moving_scene(), at_once = moving_scene();
  still.velocity = {};
  at_once.sensor.shutter.readout_s = 0;
  for (const Scene& scene : {still, at_once}) {
    EXPECT_EQ(render_light(scene, families, kFacing).pixels(), expected.pixels());
    EXPECT_EQ(visible_corners(scene, kFacing).front().pixel,
              visible_corners(global, kFacing).front().pixel);
  }
}

TEST(RollingShutter, DepthIsThatOfThePoseOfTheLine) {
  const Scene scene = moving_scene();
  const ImageF rolling = render_depth(scene, kFacing);
  Scene still = scene;
  still.velocity = {};
  const double seconds = scene.sensor.shutter.seconds_at({0, 40}, kRolledSize);
  const ImageF whole = render_depth(still, moved_for(seconds, scene.velocity, kFacing));
  for (int x = 40; x < 50; ++x) EXPECT_NEAR(rolling(x, 40), whole(x, 40), 1e-6);
}

// Seconds of work for the corners of a board of side x side, all in the picture.
double seconds_for_corners(int side) {
  Scene scene = moving_scene();
  scene.boards = {
      {make_board(Checkerboard{side, side, 0.6 / side, 0.4 / side}), translation({-0.3, -0.2, 1})}};
  const std::clock_t start = std::clock();
  EXPECT_EQ(visible_corners(scene, kFacing).size(), static_cast<std::size_t>(side * side));
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

// Four times the corners are four times the work, or sixteen if each goes through all of them.
TEST(RollingShutter, TheWorkGrowsAsTheNumberOfCorners) {
  constexpr double kSlack = 0.1;  // seconds, the noise of a busy machine
  EXPECT_LT(seconds_for_corners(80), 8 * seconds_for_corners(40) + kSlack);
}

TEST(RollingShutter, ThereIsNoVelocityAlongAPathWithoutPosesBetweenItsViews) {
  MovingScene moving;
  moving.settings.num_views = 2;
  moving.period_s = 0.1;
  for (const CameraPath& path :
       {CameraPath(DomePath()), CameraPath(ExplicitPath{{kFacing, Pose()}})}) {
    moving.settings.path = path;
    moving.velocity = {};
    EXPECT_TRUE(scene_in_view(moving, 1).velocity.turn_rad_s.isZero(0));
    moving.velocity = [](double) { return CameraVelocity{{0.1, 0, 0}, {0, 0, 2}}; };
    EXPECT_EQ(scene_in_view(moving, 1).velocity.move_m_s, Vector3d(0, 0, 2));
  }
}

TEST(RollingShutter, DoesNotGoWithAFocus) {
  Scene scene = moving_scene();
  scene.sensor.focus = Focus{1, 0.01};
  EXPECT_THROW(check_sensor(scene.camera, scene.sensor), Error);
}

// A circle of 2 m at a turn a second: v = 2 pi r, w = 2 pi.
TEST(RollingShutter, TheVelocityAlongAPathIsItsDerivative) {
  MovingScene moving;
  moving.settings.camera = {pinhole(90, 90, 47.5, 31.5), kRolledSize};
  moving.settings.num_views = 11;
  moving.settings.path = RingPath{{0, 0, 0}, 2, 0, std::numbers::pi, {0, 0, 0}};
  moving.period_s = 0.05;
  const CameraVelocity inside = scene_in_view(moving, 4).velocity;
  EXPECT_NEAR(inside.move_m_s.norm(), 2 * 2 * std::numbers::pi / 2 * 2, 1e-4);
  EXPECT_NEAR(inside.turn_rad_s.norm(), 2 * std::numbers::pi, 1e-4);
  moving.velocity = [](double t) { return CameraVelocity{{0, 0, t}, {}}; };
  EXPECT_NEAR(scene_in_view(moving, 5).velocity.turn_rad_s.z() - inside.turn_rad_s.z(), 0.5, 1e-4);
  EXPECT_TRUE(moves(moving));
}

}  // namespace
}  // namespace tagcal
