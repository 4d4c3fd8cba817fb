#include "tagcal/scene/rig_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <set>

#include "expect.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/io/scene_file.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

constexpr double kWholeTurn = 2 * std::numbers::pi;

// The rig's frame goes around a board on the floor; the eye of a camera is at most 2 m away.
RigScene around_a_board(int num_views) {
  RigScene rig;
  rig.scene.settings.num_views = num_views;
  rig.scene.settings.path =
      FunctionPath{[](double t) {
                     return camera_from_world_on_orbit(
                         {Vector3d(0.2 * t, 0, 0), 1.4, kWholeTurn * t / 3, 0.9, t});
                   },
                   {}};
  rig.scene.boards = {
      {kWorldFrame,
       {make_board(AprilGrid{.columns = 4, .rows = 3, .tag_size = 0.08, .tag_spacing = 0.3}),
        translation({-0.2, -0.15, 0})}}};
  rig.cameras = {
      {"left", {pinhole(500, 505, 321, 238), {640, 480}}, "pinhole", Pose()},
      {"right",
       {pinhole(620, 618, 400, 290), {800, 600}},
       "pinhole",
       translation({0.11, 0.002, -0.003}) * rotation_about_y(-0.05)},
  };
  return rig;
}

Pose truth_of(const RigDataset& rig, std::size_t camera, std::size_t view) {
  return rig.cameras[camera].data.truth->camera_from_world.at(image_name(static_cast<int>(view)));
}

double largest_difference(const View& a, const View& b) {
  EXPECT_EQ(a.observations.size(), b.observations.size());
  double most = 0;
  for (std::size_t i = 0; i < std::min(a.observations.size(), b.observations.size()); ++i) {
    EXPECT_EQ(a.observations[i].id, b.observations[i].id);
    most = std::max(most, (a.observations[i].pixel - b.observations[i].pixel).norm());
  }
  return most;
}

// OpenCV's projection of a point by camera_from_rig * rig_from_world, with rig_from_world from the
// path itself.
Eigen::Vector2d projected(const RigScene& rig, std::size_t camera, const Pose& rig_from_world,
                          const Vector3d& point) {
  const Pose camera_from_world = rig.cameras[camera].rig_from_camera.inverse() * rig_from_world;
  const Vector3d in_camera = camera_from_world * point;
  const auto p = parameters(rig.cameras[camera].camera.lens);
  const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(std::vector<cv::Point3d>{{in_camera.x(), in_camera.y(), in_camera.z()}},
                    cv::Vec3d(), cv::Vec3d(), k, cv::noArray(), pixels);
  return {pixels[0].x, pixels[0].y};
}

TEST(RigScene, CornersAreTheProjectionsOfOpenCv) {
  const RigScene rig = around_a_board(7);
  const RigDataset exact = exact_rig_dataset(rig, 0, nullptr);
  const auto path = std::get<FunctionPath>(rig.scene.settings.path).camera_from_world;
  ASSERT_EQ(exact.cameras.size(), 2U);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(exact.cameras[c].name, rig.cameras[c].name);
    EXPECT_EQ(exact.cameras[c].data.image_size, rig.cameras[c].camera.image_size);
    const auto points = points_in_world(exact.cameras[c].data.boards);
    std::size_t num_corners = 0;
    for (int view = 0; view < 7; ++view)
      for (const Observation& o :
           exact.cameras[c].data.views[static_cast<std::size_t>(view)].observations) {
        const auto pixel = projected(rig, c, path(time_of_view(view, 7)), points.at(o.id));
        EXPECT_LT((pixel - o.pixel).norm(), 1e-9);
        ++num_corners;
      }
    EXPECT_GT(num_corners, 250U);
  }
}

TEST(RigScene, InstantsTimesAndTruth) {
  const RigScene rig = around_a_board(5);
  const RigDataset exact = exact_rig_dataset(rig, 0, nullptr);
  ASSERT_EQ(exact.instants.size(), 5U);
  EXPECT_EQ(exact.instants[3].view, (std::vector<std::optional<std::size_t>>{3, 3}));
  EXPECT_EQ(exact.cameras[1].times_s[0], 0);
  EXPECT_DOUBLE_EQ(exact.cameras[1].times_s[4], 0.2);
  ASSERT_TRUE(exact.truth);
  for (std::size_t view = 0; view < 5; ++view) {
    const Pose right_from_left = truth_of(exact, 1, view) * truth_of(exact, 0, view).inverse();
    const Pose expected =
        exact.truth->camera_from_rig[1] * exact.truth->camera_from_rig[0].inverse();
    EXPECT_LT(distance_between_m(right_from_left, expected), 1e-12);
    EXPECT_LT(angle_between_rad(right_from_left, expected), 1e-12);
  }
}

// 3 periods of 50 ms are not 0.15 s to the last bit.
TEST(RigScene, AnOffsetOfWholePeriodsShiftsThePictures) {
  for (const double jitter_m : {0.0, 0.01}) {
    RigScene rig = around_a_board(9);
    rig.scene.settings.jitter.position_m = jitter_m;
    rig.cameras[1].camera = rig.cameras[0].camera;
    rig.cameras[1].rig_from_camera = Pose();
    for (const int periods : {3, -2}) {
      rig.cameras[1].time_offset_s = periods * 50 * 1e-3;
      const RigDataset exact = exact_rig_dataset(rig, 11, nullptr);
      EXPECT_EQ(exact.truth->time_offset_s[1], rig.cameras[1].time_offset_s);
      for (int view = 0; view < 9; ++view) {
        const auto then = static_cast<std::size_t>(std::clamp(view + periods, 0, 8));
        const auto now = static_cast<std::size_t>(view);
        EXPECT_EQ(
            largest_difference(exact.cameras[1].data.views[now], exact.cameras[0].data.views[then]),
            0);
        EXPECT_EQ(exact.cameras[1].times_s[now], exact.cameras[0].times_s[now]);
      }
    }
  }
}

TEST(RigScene, APartOfAPeriodIsOnThePath) {
  RigScene rig = around_a_board(5);
  rig.cameras[1] = rig.cameras[0];
  rig.cameras[1].time_offset_s = 0.02;
  const auto path = std::get<FunctionPath>(rig.scene.settings.path).camera_from_world;
  const RigDataset exact = exact_rig_dataset(rig, 0, nullptr);
  for (std::size_t view = 0; view < 4; ++view) {
    const Pose expected = path((static_cast<double>(view) + 0.4) / 4);
    EXPECT_LT(distance_between_m(truth_of(exact, 1, view), expected), 1e-12);
    EXPECT_LT(angle_between_rad(truth_of(exact, 1, view), expected), 1e-12);
  }
  // Listed poses: half of the screw motion from one to the next.
  const Pose first = path(0), second = path(0.25);
  rig.scene.settings.path = ExplicitPath{{first, second}};
  rig.scene.settings.num_views = 2;
  rig.cameras[1].time_offset_s = 0.025;
  const RigDataset listed = exact_rig_dataset(rig, 0, nullptr);
  const Pose half = first.inverse() * truth_of(listed, 1, 0);
  const Pose whole = first.inverse() * second;
  EXPECT_LT((2 * log_pose(half) - log_pose(whole)).norm(), 1e-12);
  EXPECT_EQ(largest_difference(listed.cameras[1].data.views[1], listed.cameras[0].data.views[1]),
            0);
}

TEST(RigScene, MovedBoardsAreSeenAsFromAMovedRig) {
  RigScene rig = around_a_board(6);
  rig.cameras[1].time_offset_s = 0.03;
  const RigDataset moved_rig = exact_rig_dataset(rig, 0, nullptr);
  rig.boards_move = true;
  const RigDataset moved_boards = exact_rig_dataset(rig, 0, nullptr);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_LT((moved_rig.cameras[c].data.boards[0].world_from_board.matrix() -
               moved_boards.cameras[0].data.boards[0].world_from_board.matrix())
                  .norm(),
              1e-12);
    for (std::size_t view = 0; view < 6; ++view) {
      EXPECT_LT(largest_difference(moved_rig.cameras[c].data.views[view],
                                   moved_boards.cameras[c].data.views[view]),
                1e-9);
      EXPECT_LT(distance_between_m(truth_of(moved_rig, c, view), truth_of(moved_boards, c, view)),
                1e-12);
    }
    // The rig itself stands still.
    const auto poses = camera_poses(scene_of_camera(rig, c, 0), 0);
    EXPECT_EQ(poses[0].matrix(), poses[5].matrix());
  }
}

// Boards that `motion` moves: all cameras share one world, also those that see the first instant
// later, and what is not rigid in one camera's time is in no data set.
TEST(RigScene, CamerasOfDifferentTimesShareBoardsAndWorld) {
  RigScene rig = around_a_board(5);
  rig.scene.settings.path =
      FunctionPath{[](double) {
                     return camera_from_world_on_orbit({Vector3d::Zero(), 1.4, 0, 0.9, 0});
                   },
                   {}};
  rig.scene.frames = {
      {"table", kWorldFrame, [](double t) { return affine(rotation_about_z(t)); }, true},
      {"late", "table",
       [](double t) {
         return affine(translation({t > 0.99 ? 0.1 : 0.0, 0, 0}));
       },
       true}};
  rig.scene.boards[0].frame = "table";
  rig.scene.boards.push_back(
      {"late", {make_board(Tags{.tags = {{100, 0.1, {}}}}), translation({0.3, 0, 0})}});
  rig.cameras[0].time_offset_s = -0.05;  // never sees the jump of the second board
  rig.cameras[1].time_offset_s = 0.02;
  std::vector<std::string> warnings;
  const RigDataset exact = exact_rig_dataset(rig, 0, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_HAS(warnings[0], "boards[1] moves relative to the first board");
  for (const RigCamera& camera : exact.cameras) {
    ASSERT_EQ(camera.data.boards.size(), 1U);
    EXPECT_EQ(camera.data.boards[0].world_from_board.matrix(),
              exact.cameras[0].data.boards[0].world_from_board.matrix());
    const auto points = points_in_world(camera.data.boards);
    for (const View& view : camera.data.views)
      for (const Observation& o : view.observations) {
        const Truth& truth = *camera.data.truth;
        const auto pixel =
            project(truth.camera.lens, truth.camera_from_world.at(view.image) * points.at(o.id));
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - o.pixel).norm(), 1e-9);
      }
  }
}

TEST(RigScene, CamerasHaveNoiseOfTheirOwn) {
  EXPECT_EQ(camera_seed(7, 0), 7U);
  EXPECT_NE(camera_seed(7, 1), camera_seed(7, 2));
  EXPECT_NE(noise_seed(camera_seed(7, 1), 0), noise_seed(7, 0));
}

TEST(RigScene, TheShippedScenesAreWhatTheySay) {
  const auto read = [](const std::string& name) {
    return exact_rig_dataset(
        std::get<RigScene>(read_any_scene(std::filesystem::path(TAGCAL_SOURCE_DIR) /
                                          "data-synthetic/scenes" / (name + ".yaml"))),
        0, nullptr);
  };
  // By pair of cameras: the instants in which both see a corner of one board.
  const auto common = [](const RigDataset& rig, std::size_t a, std::size_t b) {
    std::size_t count = 0;
    for (const Instant& instant : rig.instants) {
      std::set<CornerId> seen;
      for (const auto& o : rig.cameras[a].data.views[*instant.view[a]].observations)
        seen.insert(o.id);
      count += std::ranges::any_of(rig.cameras[b].data.views[*instant.view[b]].observations,
                                   [&](const Observation& o) { return seen.contains(o.id); });
    }
    return count;
  };
  const RigDataset stereo = read("stereo");
  EXPECT_EQ(common(stereo, 0, 1), stereo.instants.size());
  EXPECT_NEAR(stereo.truth->camera_from_rig[1].translation().norm(), 0.11, 1e-4);
  const RigDataset ring = read("ring_of_six");
  for (std::size_t c = 0; c < 6; ++c) {
    EXPECT_GE(common(ring, c, (c + 1) % 6), 10U);
    EXPECT_EQ(common(ring, c, (c + 3) % 6), 0U);
  }
  const RigDataset wheel = read("wheel");
  EXPECT_EQ(common(wheel, 0, 1), 0U);
}

}  // namespace
}  // namespace tagcal
