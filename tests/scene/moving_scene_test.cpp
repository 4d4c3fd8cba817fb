#include "tagcal/scene/moving_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "expect.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;

MovingFrame still(const std::string& name, const std::string& parent, const Affine& transform) {
  return {name, parent, [transform](double) { return transform; }};
}

Board one_tag(int id) { return make_board(Tags{.tags = {{id, 0.2, {}}}}); }

// A camera 3 m before the origin that looks along +y, z up.
MovingScene before_the_origin(int num_views) {
  MovingScene scene;
  scene.settings.camera = {pinhole(500, 500, 319.5, 239.5), {640, 480}};
  scene.settings.model = "f";
  scene.settings.num_views = num_views;
  scene.settings.path =
      FunctionPath{[](double) {
                     return camera_from_world_looking_at({0, -3, 0}, {0, 0, 0}, {0, 0, 1});
                   },
                   {}};
  return scene;
}

const Pose kFacingCamera = rotation_about_x(std::numbers::pi / 2);  // z of a board towards -y

TEST(MovingScene, ABeadOnTheSpokeOfARollingWheelRunsOnACycloid) {
  static constexpr double kRadius = 0.4;
  MovingScene scene = before_the_origin(25);
  scene.frames = {
      {"wheel", "world",
       [](double t) {
         return affine(translation({kRadius * kTurn * t, 0, kRadius}) *
                       rotation_about_y(kTurn * t));
       },
       true},
      still("bead", "wheel", affine(translation({0, 0, -kRadius})))};  // at first on the ground
  for (int view = 0; view < 25; ++view) {
    const double turn = kTurn * view / 24;
    const Vector3d bead = frames_in_view(scene, view).a_from_b("world", "bead").translation();
    const Vector3d cycloid(kRadius * (turn - std::sin(turn)), 0, kRadius * (1 - std::cos(turn)));
    EXPECT_LT((bead - cycloid).norm(), 1e-15) << view;
  }
}

TEST(MovingScene, PartsStandWhereTheirFramesPutThem) {
  MovingScene scene = before_the_origin(1);
  scene.frames = {still("table", "world", affine(translation({1, 2, 3}))),
                  still("stretched", "table", scaling({2, 1, 1}))};
  scene.boards = {{"table", {one_tag(0), translation({0.5, 0, 0})}}};
  scene.occluders = {{"stretched", {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, 0.2}}};
  const Scene stands = scene_in_view(scene, 0);
  EXPECT_EQ(stands.boards[0].world_from_board.translation(), Vector3d(1.5, 2, 3));
  EXPECT_EQ(stands.occluders[0].corners[1], Vector3d(3, 2, 3));
  EXPECT_EQ(stands.occluders[0].level, 0.2);
  EXPECT_FALSE(moves(scene));
}

std::string error_of_first_view(const MovingScene& scene) {
  return error_of([&] {
    scene_in_view(scene, 0);
    rigid_camera_frame(scene, 0);
  });
}

TEST(MovingScene, WhatIsRigidHangsOnNoScale) {
  MovingScene scene = before_the_origin(1);
  scene.frames = {still("doll's house", "world", scaling(0.1))};
  scene.boards = {{"doll's house", {one_tag(0), {}}}};
  EXPECT_EQ(error_of_first_view(scene),
            "scene: boards[0] hangs on frame 'doll's house', which scales or shears, but must be "
            "rigid");
  scene.boards = {};
  EXPECT_EQ(error_of_first_view(scene), "no error");
  scene.camera_frame = "doll's house";
  EXPECT_HAS(error_of_first_view(scene), "the camera hangs on");
  scene.camera_frame = "attic";
  EXPECT_HAS(error_of_first_view(scene), "attic");
}

TEST(MovingScene, ACameraRidesOnItsFrame) {
  MovingScene scene = before_the_origin(3);
  scene.frames = {{"cart", "world",
                   [](double t) {
                     return affine(translation({4 * t, 0, 0}));
                   },
                   true}};
  scene.camera_frame = "cart";
  const std::vector<Pose> poses = camera_poses(scene, 1);
  for (int view = 0; view < 3; ++view)
    EXPECT_LT((poses[static_cast<std::size_t>(view)].inverse().translation() -
               Vector3d(2.0 * view, -3, 0))
                  .norm(),
              1e-15);
}

// The largest distance of an observation from its point, projected by what the data set says.
double largest_error_px(const Dataset& dataset) {
  const auto points = points_in_world(dataset.boards);
  double largest = 0;
  for (const View& view : dataset.views) {
    const Pose& pose = dataset.truth->camera_from_world.at(view.image);
    for (const Observation& o : view.observations)
      largest = std::max(
          largest, (*project(dataset.truth->camera.lens, pose * points.at(o.id)) - o.pixel).norm());
  }
  return largest;
}

TEST(MovingScene, TheDataSetMovesWithItsFirstBoard) {
  MovingScene scene = before_the_origin(9);
  const auto swing = [](double t) {
    return affine(rotation_about_y(t) * translation({t / 4, 0, 0}));
  };
  const auto fall = [](double t) { return affine(translation({0, 0, -t / 4})); };
  scene.frames = {{"swing", "world", swing, true}, {"fall", "swing", fall, true}};
  scene.boards = {{"swing", {one_tag(0), kFacingCamera}},
                  {"swing", {one_tag(1), translation({0.4, 0, 0}) * kFacingCamera}},
                  {"fall", {one_tag(2), translation({-0.4, 0, 0}) * kFacingCamera}}};
  std::vector<std::string> warnings;
  const Dataset dataset = exact_dataset(scene, camera_poses(scene, 1), &warnings);
  ASSERT_EQ(dataset.boards.size(), 2U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].substr(0, 15), "boards[2] moves");
  for (const View& view : dataset.views) EXPECT_EQ(view.observations.size(), 8U);
  EXPECT_LT(largest_error_px(dataset), 1e-10);
  // What was left out stands in the truth, relative to the camera.
  const HierarchyTruth& last = dataset.truth->hierarchy.at("008.png");
  EXPECT_EQ(last.camera_from_frame.size(), 3U);
  ASSERT_EQ(last.camera_from_board.size(), 3U);
  const Pose expected = camera_poses(scene, 1)[8] * rigid(swing(1)) * rigid(fall(1)) *
                        translation({-0.4, 0, 0}) * kFacingCamera;
  EXPECT_LT(minus(last.camera_from_board[2], expected).norm(), 1e-14);
}

TEST(MovingScene, ABoardThatStandsStillKeepsTheWorld) {
  MovingScene scene = before_the_origin(4);
  scene.frames = {{"cart", "world", [](double t) { return affine(translation({t, 5, 0})); }, true}};
  scene.boards = {{"world", {one_tag(0), kFacingCamera}}, {"cart", {one_tag(1), kFacingCamera}}};
  const Dataset dataset = exact_dataset(scene, camera_poses(scene, 1), nullptr);
  EXPECT_EQ(dataset.boards.size(), 1U);
  for (const auto& [image, pose] : dataset.truth->camera_from_world)
    EXPECT_EQ(minus(pose, camera_poses(scene, 1)[0]).norm(), 0);
  EXPECT_LT(largest_error_px(dataset), 1e-10);
}

TEST(MovingScene, WithoutBoardsHasADataSetWithoutCorners) {
  MovingScene scene = before_the_origin(3);
  scene.frames = {{"cart", "world", [](double t) { return affine(translation({t, 5, 0})); }, true}};
  const Dataset dataset = exact_dataset(scene, camera_poses(scene, 1), nullptr);
  EXPECT_TRUE(dataset.boards.empty());
  ASSERT_EQ(dataset.views.size(), 3U);
  for (const View& view : dataset.views) EXPECT_TRUE(view.observations.empty());
}

TEST(MovingScene, ThroughAWindowTheEyeSeesItsCornersInTheCornersOfTheImage) {
  MovingScene scene = before_the_origin(5);
  const WindowInWorld window{{-0.4, 0, 1}, {0.4, 0, 1}, {-0.4, 0, 1.6}};
  const auto eye = [](double t) { return Vector3d(t - 0.5, -0.5 - t, 1 + t); };
  scene.settings.path =
      FunctionPath{[=](double t) {
                     return camera_behind(window, eye(t), {640, 480}).camera_from_world;
                   },
                   [=](double t) {
                     return camera_behind(window, eye(t), {640, 480}).camera.lens;
                   }};
  scene.boards = {{"world", {one_tag(0), kFacingCamera}}};
  EXPECT_TRUE(moves(scene));
  const std::vector<Pose> poses = camera_poses(scene, 1);
  for (int view = 0; view < 5; ++view) {
    const Lens lens = scene_in_view(scene, view).camera.lens;
    const Pose& pose = poses[static_cast<std::size_t>(view)];
    EXPECT_LT((pose.inverse().translation() - eye(view / 4.0)).norm(), 1e-15);
    const auto pixel = [&](const Vector3d& x) { return *project(lens, pose * x); };
    EXPECT_LT((pixel(window.lower_left) - Vector2d(-0.5, 479.5)).norm(), 1e-9);
    EXPECT_LT((pixel(window.lower_right) - Vector2d(639.5, 479.5)).norm(), 1e-9);
    EXPECT_LT((pixel(window.upper_left) - Vector2d(-0.5, -0.5)).norm(), 1e-9);
  }
  EXPECT_EQ(exact_dataset(scene, poses, nullptr).truth->lenses.size(), 5U);
}

TEST(MovingScene, ACuboidIsClosedAndFacesOutwards) {
  const std::vector<Occluder> faces = cuboid({1, 2, 3}, 0.7);
  ASSERT_EQ(faces.size(), 6U);
  double volume = 0;
  for (const Occluder& face : faces) {
    EXPECT_EQ(face.level, 0.7);
    const auto& c = face.corners;
    const Vector3d area = (c[1] - c[0]).cross(c[3] - c[0]);
    volume += area.dot(c[0]) / 3;  // divergence theorem
    EXPECT_GT(area.dot(c[0]), 0);
  }
  EXPECT_NEAR(volume, 6, 1e-14);
  EXPECT_THROW(cuboid({1, 0, 1}, 0.5), Error);
}

}  // namespace
}  // namespace tagcal
