#include <gtest/gtest.h>

#include <numbers>

#include <algorithm>
#include <set>

#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

// Looks along world +y from `eye`, z up: right is +x.
Pose looking_along_y(const Vector3d& eye) {
  return Pose(exp_rotation({std::numbers::pi / 2, 0, 0}),
              -(exp_rotation({std::numbers::pi / 2, 0, 0}) * eye));
}

// A board whose front faces -y at distance y: board x = world x, board y = world z.
Pose facing_the_camera(const Vector3d& origin) {
  return Pose(exp_rotation({std::numbers::pi / 2, 0, 0}), origin);
}

Scene one_board() {
  Scene scene;
  scene.camera = {pinhole(500, 500, 319.5, 239.5), {640, 480}};
  scene.boards = {
      {make_board(AprilGrid{2, 2, 0.1, 0.3, 0}), facing_the_camera({-0.115, 1, -0.115})}};
  return scene;
}

Occluder wall(double x0, double x1, double y, double z0 = -5, double z1 = 5) {
  return {{{x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1}}, 0.3};
}

std::set<int> tags_seen(const Scene& scene, const Pose& pose) {
  std::set<int> tags;
  for (const Observation& o : visible_corners(scene, pose)) tags.insert(o.id.tag_id);
  return tags;
}

TEST(Visibility, CornersAreWhereTheLensPutsThem) {
  const Scene scene = one_board();
  const Pose camera = looking_along_y({0, 0, 0});
  const auto seen = visible_corners(scene, camera);
  ASSERT_EQ(seen.size(), 16u);
  EXPECT_TRUE(std::ranges::is_sorted(seen, {}, &Observation::id));
  // Tag 0 is lower left: x = -0.115, z = -0.115, 1 m ahead.
  EXPECT_LT((seen[0].pixel - Eigen::Vector2d(319.5 - 57.5, 239.5 + 57.5)).norm(), 1e-9);
  const auto points = points_in_world(scene.boards);
  for (const Observation& o : seen)
    EXPECT_EQ(o.pixel, *project(scene.camera.lens, camera * points.at(o.id)));
}

TEST(Visibility, NotFromBehindNorBehindTheCamera) {
  const Scene scene = one_board();
  EXPECT_TRUE(visible_corners(scene, looking_along_y({0, 2, 0})).empty());  // board behind
  const Pose back(exp_rotation({0, std::numbers::pi, 0}), Vector3d::Zero());
  const Pose turned = back * looking_along_y({0, 2, 0});  // looks at the back of the board
  ASSERT_GT((turned * Vector3d(0, 1, 0)).z(), 0);
  EXPECT_TRUE(visible_corners(scene, turned).empty());
}

// The corners of a checkerboard have a face as those of tags; the markers of a ChArUco board are
// not observed.
TEST(Visibility, CheckersAreSeenFromTheFront) {
  const Checkerboard squares{
      .columns = 3, .rows = 2, .column_spacing = 0.1, .row_spacing = 0.1, .first_id = 40};
  for (const Board& board :
       {make_board(squares), make_board(Charuco{4, 3, 0.1, 0.07, "tag36h11", false, 40})}) {
    Scene scene = one_board();
    scene.boards = {{board, facing_the_camera({-0.1, 1, -0.05})}};
    const Pose camera = looking_along_y({0, 0, 0});
    const auto seen = visible_corners(scene, camera);
    ASSERT_EQ(seen.size(), 6u);
    EXPECT_EQ(seen[0].id, (CornerId{40, 0}));
    EXPECT_LT((seen[0].pixel - Eigen::Vector2d(319.5 - 50, 239.5 + 25)).norm(), 1e-9);
    EXPECT_TRUE(visible_corners(scene, looking_along_y({0, 2, 0})).empty());
    const Pose back(exp_rotation({0, std::numbers::pi, 0}), Vector3d::Zero());
    EXPECT_TRUE(visible_corners(scene, back * looking_along_y({0, 2, 0})).empty());
    scene.occluders = {wall(-5, -0.02, 0.5)};
    EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{41, 42, 44, 45}));
    EXPECT_EQ(named_corner(scene, {40, 0})->name, "corner 40");
    // Its white squares hide what is behind them.
    scene.occluders.clear();
    const Board point = make_board(Points{{{{7, 0}, {-0.149, 1.5, 0}}}});
    scene.boards.push_back({point, Pose()});
    EXPECT_FALSE(tags_seen(scene, camera).contains(7));
  }
}

TEST(Visibility, OnlyInsideTheImage) {
  const Scene scene = one_board();
  const Pose camera = looking_along_y({0.64, 0, 0});  // the image reaches to x = 0.64 - 0.64
  for (const Observation& o : visible_corners(scene, camera)) {
    EXPECT_GE(o.pixel.x(), -0.5);
    EXPECT_LT(o.pixel.x(), 639.5);
  }
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{1, 3}));
}

TEST(Visibility, OccludersHideWhatIsBehindThem) {
  Scene scene = one_board();
  const Pose camera = looking_along_y({0, 0, 0});
  scene.occluders = {wall(-5, 0, 0.5)};
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{1, 3}));
  scene.occluders = {wall(-5, 0, 1.5)};  // behind the board
  EXPECT_EQ(tags_seen(scene, camera).size(), 4u);
  scene.occluders = {wall(-5, 0, -0.5)};  // behind the camera
  EXPECT_EQ(tags_seen(scene, camera).size(), 4u);
  scene.occluders = {wall(-5, 5, 1.0)};  // in the plane of the board: a desk it lies on
  EXPECT_EQ(tags_seen(scene, camera).size(), 4u);
  std::ranges::reverse(scene.occluders[0].corners);
  scene.occluders = {wall(0, -5, 0.5)};  // seen from its other side
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{1, 3}));
}

TEST(Visibility, ThroughADoorway) {
  Scene scene = one_board();
  const Pose camera = looking_along_y({0, 0, 0});
  // Half way, a gap from x = -0.03 to x = 0.03: at the board, from -0.06 to 0.06.
  scene.occluders = {wall(-5, -0.03, 0.5), wall(0.03, 5, 0.5)};
  std::set<CornerId> seen;
  for (const Observation& o : visible_corners(scene, camera)) seen.insert(o.id);
  // The inner columns of corners, at x = -0.015 and x = 0.015.
  EXPECT_EQ(seen,
            (std::set<CornerId>{{0, 1}, {0, 2}, {1, 0}, {1, 3}, {2, 1}, {2, 2}, {3, 0}, {3, 3}}));
}

TEST(Visibility, PaperOfAnotherBoardHides) {
  Scene scene = one_board();
  // Its tag ends at x = -0.06 half way, its paper with corner squares and margin at -0.01.
  const double square = 0.03;
  scene.boards.push_back(
      {make_board(AprilGrid{1, 1, 0.1, 0.3, 10}), facing_the_camera({-0.11 - square, 0.5, -0.05})});
  const Pose camera = looking_along_y({0, 0, 0});
  const auto paper_end = -0.01 - square + square + 0.02;
  EXPECT_GT(paper_end, -0.0075);  // hides the corners of tags 0 and 2 at x = -0.015, 1 m away
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{1, 3, 10}));
  // Its back hides as well, and shows no corners.
  scene.boards[1].world_from_board =
      scene.boards[1].world_from_board * Pose(exp_rotation({0, std::numbers::pi, 0}), {0.1, 0, 0});
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{1, 3}));
}

TEST(Visibility, PointsHaveNoFaceButCanBeHidden) {
  Scene scene = one_board();
  scene.boards.clear();
  const Board points = make_board(Points{{{{5, 0}, {-0.2, 1, 0}}, {{3, 0}, {0.2, 1, 0}}}});
  scene.boards = {{points, Pose()}};
  const Pose camera = looking_along_y({0, 0, 0});
  const Pose other_side =
      Pose(exp_rotation({0, std::numbers::pi, 0}), Vector3d::Zero()) * looking_along_y({0, 2, 0});
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{3, 5}));
  EXPECT_EQ(tags_seen(scene, other_side), (std::set<int>{3, 5}));
  scene.occluders = {wall(-5, 0, 0.5)};
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{3}));
  EXPECT_EQ(tags_seen(scene, other_side), (std::set<int>{3, 5}));
}

TEST(Visibility, SidesOfACubeHideEachOther) {
  Scene scene = one_board();
  Tags cube;
  // Front face towards -y, and a face towards +x behind it.
  cube.tags = {{0, 0.08, Pose(exp_rotation({std::numbers::pi / 2, 0, 0}), {0, -0.06, 0})},
               {1, 0.08, Pose(exp_rotation({0, std::numbers::pi / 2, 0}), {0.06, 0, 0})}};
  scene.paper_margin_m = 0.02;
  scene.boards = {{make_board(cube), Pose(Eigen::Quaterniond::Identity(), {0, 1, 0})}};
  EXPECT_EQ(tags_seen(scene, looking_along_y({0, 0, 0})), (std::set<int>{0}));
  EXPECT_EQ(tags_seen(scene, looking_along_y({0.5, 0, 0})), (std::set<int>{0, 1}));
}

TEST(Visibility, ParallelRaysComeFromAllAlongTheAxis) {
  Scene scene = one_board();
  scene.camera.lens = Parallel({500, 500, 319.5, 239.5});
  const Pose camera = looking_along_y({0, 0, 0});
  EXPECT_EQ(tags_seen(scene, camera).size(), 4u);
  // There is no behind of the camera.
  EXPECT_EQ(tags_seen(scene, looking_along_y({0, 2, 0})).size(), 4u);
  scene.occluders = {wall(-5, 0, -3)};
  EXPECT_EQ(tags_seen(scene, camera), (std::set<int>{1, 3}));
  scene.occluders = {wall(-5, 0, 3)};
  EXPECT_EQ(tags_seen(scene, camera).size(), 4u);
}

// Where sheets lie in one plane, papers lie on occluders, and later things on earlier ones.
TEST(Visibility, WhatLiesOnWhatInACommonPlane) {
  Scene scene;
  scene.camera = {pinhole(500, 500, 319.5, 239.5), {640, 480}};
  const Pose turned(exp_rotation({0.4, -0.2, 0.3}), {0.1, 0.2, 5});
  scene.boards = {{make_board(AprilGrid{1, 1, 0.2, 0.3, 0}), turned},
                  {make_board(AprilGrid{1, 1, 0.2, 0.3, 1}), turned}};
  const auto desk_at = [&](double height) {
    Occluder desk;
    for (const auto& [x, y] : {std::pair(-9, -9), {1, -9}, {1, 1}, {-9, 1}})
      desk.corners.push_back(turned * Vector3d(x, y, height));
    return desk;
  };
  const auto seen_at = [&](double height) {
    scene.occluders = {desk_at(height)};
    const auto side = turned.rotation() * Vector3d::UnitZ();
    return tags_seen(scene, camera_from_world_looking_at(turned * Vector3d(0.1, 0.1, 1),
                                                         turned * Vector3d(0.1, 0.1, 0),
                                                         side.cross(Vector3d::UnitX())));
  };
  EXPECT_EQ(seen_at(0), (std::set<int>{1}));
  EXPECT_EQ(seen_at(-0.01), (std::set<int>{1}));
  EXPECT_EQ(seen_at(0.01), (std::set<int>{}));
}

}  // namespace
}  // namespace tagcal
