#include <gtest/gtest.h>

#include "calibrations.hpp"
#include "spoiled_worlds.hpp"
#include "tagcal/estimate/calibrate.hpp"

// Wrong corners, tags, views and boards: the right answer with all of them listed, or a refusal.

namespace tagcal {
namespace {

SpoiledWorld usual_world(int seed) { return untouched(make_world(opencv5_lens(), seed)); }

std::set<CornerName> listed(const Calibration& c) {
  std::set<CornerName> names;
  for (const Outlier& o : c.outliers) names.insert({o.image, o.id});
  return names;
}

std::size_t num_corners(const Dataset& dataset) {
  std::size_t count = 0;
  for (const View& view : dataset.views) count += view.observations.size();
  return count;
}

void expect_true_lens(const Calibration& c) {
  ASSERT_EQ(c.status, Status::ok);
  ASSERT_EQ(c.model, c.steps.empty() ? "opencv5" : "opencv4");  // asked for; the smallest
  const Lens truth = opencv5_lens();
  for (std::size_t i = 0; i < parameters(truth).size(); ++i)
    EXPECT_LE(std::abs(parameters(c.camera->lens)[i] - parameters(truth)[i]),
              4 * c.sigmas[i] + 1e-12)
        << parameter_names(truth)[i];
}

// The truth, every wrong corner in the list, and few others.
void expect_answer(const SpoiledWorld& world, const std::string& model) {
  const Calibration c = calibrate(world.dataset, with_model(model));
  expect_true_lens(c);
  const std::set<CornerName> out = listed(c);
  EXPECT_EQ(out.size(), c.outliers.size()) << "a corner is listed twice";
  std::size_t kept = 0, lost = 0;
  for (const CornerName& name : world.wrong) kept += !out.contains(name);
  for (const CornerName& name : out) lost += !world.wrong.contains(name);
  EXPECT_EQ(kept, 0u);
  EXPECT_LE(static_cast<double>(lost), 0.005 * static_cast<double>(num_corners(world.dataset)));
  EXPECT_EQ(c.num_corners + out.size(), num_corners(world.dataset));
}

TEST(RobustCalibration, WrongCorners) {
  for (const double share : {0.01, 0.05, 0.2}) {
    for (const double reach_px : {0.0, 20.0}) {  // anywhere, and near
      SCOPED_TRACE(testing::Message() << share << " " << reach_px);
      SpoiledWorld world = usual_world(1);
      Random random(7);
      spoil_corners(world, share, reach_px, random);
      expect_answer(world, "opencv5");
    }
  }
  SpoiledWorld world = usual_world(2);
  Random random(8);
  spoil_corners(world, 0.2, 20, random);
  expect_answer(world, "auto");
}

TEST(RobustCalibration, WrongIds) {
  SpoiledWorld one_view = usual_world(3);
  permute(one_view, 4, swapping(3, 20));
  expect_answer(one_view, "opencv5");
  SpoiledWorld all_views = usual_world(4);
  for (std::size_t v = 0; v < 20; ++v) permute(all_views, v, swapping(14, 15));
  expect_answer(all_views, "opencv5");
}

TEST(RobustCalibration, RotatedTags) {
  SpoiledWorld one_tag = usual_world(5);
  permute(one_tag, 4, rotating(9, 1));
  expect_answer(one_tag, "opencv5");
  SpoiledWorld everywhere = usual_world(6);  // stuck on the wrong way
  for (std::size_t v = 0; v < 20; ++v) permute(everywhere, v, rotating(21, 1));
  expect_answer(everywhere, "opencv5");
  SpoiledWorld one_view = usual_world(7);
  permute(one_view, 11, rotating(-1, 1));
  expect_answer(one_view, "opencv5");
}

TEST(RobustCalibration, MirroredViews) {
  for (const std::size_t count : {1, 6}) {
    SpoiledWorld world = usual_world(3);
    for (std::size_t v = 0; v < count; ++v) mirror(world, v);
    expect_answer(world, count == 1 ? "auto" : "opencv5");
  }
  SpoiledWorld all = usual_world(3);
  for (std::size_t v = 0; v < 20; ++v) mirror(all, v);
  const Calibration c = calibrate(all.dataset);
  EXPECT_EQ(c.status, Status::no_consensus);
  EXPECT_EQ(c.outliers.size(), all.wrong.size());
  ASSERT_EQ(c.findings.size(), 21u);
  EXPECT_EQ(c.findings[0].sentence, "0.png: rejected, its tags are mirrored");
  EXPECT_EQ(c.findings[20].code, "no_consensus");
}

TEST(RobustCalibration, BadViews) {
  for (const std::size_t count : {1, 6}) {  // 6 of 20: 30 %
    SpoiledWorld world = usual_world(9);
    Random random(9);
    for (std::size_t v = 0; v < count; ++v) spoil_view(world, v + 3, random);
    expect_answer(world, "opencv5");
  }
}

// Which half is right no one can say: the view as a whole is left out.
TEST(RobustCalibration, ABoardThatMovedDuringTheExposure) {
  const struct {
    int seed;
    Half half;
    Eigen::Vector2d by_px;
    const char* model;
  } cases[] = {{6, Half::right, {4, 3}, "auto"},
               {4, Half::right, {25, 15}, "opencv5"},
               {14, Half::right, {2, 0}, "opencv5"},
               {5, Half::odd, {2, 0}, "opencv5"},
               {10, Half::odd, {25, 15}, "opencv5"}};
  for (const auto& k : cases) {
    SCOPED_TRACE(k.seed);
    SpoiledWorld world = usual_world(k.seed);
    shift_half(world, 5, k.half, k.by_px);
    for (const Observation& seen : world.dataset.views[5].observations)
      world.wrong.insert({"5.png", seen.id});
    expect_answer(world, k.model);
  }
}

// In the views after the move, one of the two boards is left out: either holds the camera.
TEST(RobustCalibration, ABoardThatMovedBetweenViews) {
  for (const double by_m : {0.005, 0.05}) {
    const SpoiledWorld world = moved_board(opencv5_lens(), 3, 16, 11, 16,
                                           Pose(Eigen::Quaterniond::Identity(), {by_m, 0, 0}));
    for (const char* model : {"opencv5", "auto"}) {
      const Calibration c = calibrate(world.dataset, with_model(model));
      expect_true_lens(c);
      std::map<std::string, std::set<bool>> boards_out;
      for (const Outlier& o : c.outliers) boards_out[o.image].insert(o.id.tag_id >= 16);
      EXPECT_EQ(boards_out.size(), 5u);
      for (const auto& [image, boards] : boards_out) {
        EXPECT_GE(std::stoi(image), 11);
        EXPECT_EQ(boards.size(), 1u) << image;
      }
    }
  }
}

TEST(RobustCalibration, GoodCornersStay) {
  for (int seed = 1; seed <= 10; ++seed) {
    const Calibration c = calibrate(usual_world(seed).dataset, with_model("opencv5"));
    EXPECT_EQ(c.views.size(), 20u);
    EXPECT_LE(c.outliers.size(), 1u);
  }
}

TEST(RobustCalibration, RejectionCanBeSwitchedOff) {
  SpoiledWorld world = usual_world(4);
  shift_half(world, 5, Half::right, {25, 15});
  CalibrateOptions options = with_model("opencv5");
  options.reject_outliers = false;
  EXPECT_TRUE(calibrate(world.dataset, options).outliers.empty());
}

}  // namespace
}  // namespace tagcal
