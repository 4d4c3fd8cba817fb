// The frames of a clip that a calibration uses.
#include "tagcal/estimate/frame_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

constexpr int kFrames = 150;

// A camera that rests above the board, with now and then a view from the side, and moves fast in
// its frames 40 to 49.
Dataset clip(std::uint64_t seed) {
  const Camera camera{opencv5_lens(), {1280, 800}};
  Dataset dataset{camera.image_size, {{usual_board(), Pose()}}, {}, {}};
  const auto points = target_points(dataset.boards.front().board);
  WorldOptions options;
  options.sigma_px = 0.1;
  Random random(seed);
  for (int i = 0; i < kFrames; ++i) {
    const bool is_fast = i >= 40 && i < 50, is_tilted = i % 15 == 7;
    const double tilt = is_tilted || is_fast ? 0.7 : 0.05;
    const double azimuth = is_fast ? 0.3 * i : is_tilted ? 0.4 * i : 0.002 * i;
    const Eigen::Vector3d centre(0.33, 0.33, 0);
    const Eigen::Vector3d eye = centre + cartesian_from_spherical({1.0, tilt, azimuth});
    const Pose pose = camera_from_world_looking_at(eye, centre, Eigen::Vector3d::UnitY());
    View view = observe(camera, pose, points, options, random);
    view.image = std::to_string(i);
    dataset.views.push_back(std::move(view));
  }
  return dataset;
}

std::vector<double> times(double period_s = 1.0 / 30) {
  std::vector<double> times_s;
  for (int i = 0; i < kFrames; ++i) times_s.push_back(period_s * i);
  return times_s;
}

TEST(FrameChoice, TakesWhatAddsMost) {
  const Dataset dataset = clip(1);
  const FrameSelection chosen = choose_frames(dataset, times());
  ASSERT_EQ(chosen.fates.size(), dataset.views.size());
  EXPECT_GT(chosen.used.size(), 5U);
  EXPECT_LT(chosen.used.size(), 120U);
  for (const std::size_t view : chosen.used) EXPECT_EQ(chosen.fates[view], FrameFate::used);
  // All views from the side tell the focal length.
  int tilted = 0;
  for (const std::size_t view : chosen.used) tilted += view % 15 == 7;
  EXPECT_GE(tilted, 5);
  EXPECT_GT(chosen.projection_px, chosen.all_px);
  EXPECT_LT(chosen.projection_px, 3 * chosen.all_px);
  EXPECT_EQ(choose_frames(dataset, times()).fates, chosen.fates);
}

TEST(FrameChoice, EndsAtItsGoal) {
  const Dataset dataset = clip(2);
  const FrameSelection all = choose_frames(dataset, times());
  const double goal_px = 2 * all.projection_px;
  const FrameSelection some = choose_frames(dataset, times(), {}, goal_px);
  EXPECT_LT(some.used.size(), all.used.size());
  EXPECT_LE(some.projection_px, goal_px);
}

TEST(FrameChoice, LeavesOutWhatIsFastOrEmpty) {
  Dataset dataset = clip(3);
  dataset.views[20].observations.resize(3);
  const FrameSelection chosen = choose_frames(dataset, times());
  EXPECT_EQ(chosen.fates[20], FrameFate::no_board);
  for (std::size_t i = 41; i < 49; ++i) {
    EXPECT_EQ(chosen.fates[i], FrameFate::fast) << i;
    EXPECT_GT(chosen.speeds_px[i], 240);
  }
  EXPECT_NE(chosen.fates[100], FrameFate::fast);
}

// Speeds are those in time: the same views seconds apart are slow.
TEST(FrameChoice, CountsTheTimeBetweenViews) {
  const FrameSelection chosen = choose_frames(clip(4), times(30));
  EXPECT_EQ(std::ranges::count(chosen.fates, FrameFate::fast), 0);
}

TEST(FrameChoice, FewAreAllUsed) {
  Dataset dataset = clip(5);
  dataset.views.resize(60);
  EXPECT_EQ(choose_frames(dataset, std::vector<double>(60, 0.0)).used.size(), 60U);
}

}  // namespace
}  // namespace tagcal
