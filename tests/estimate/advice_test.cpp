#include "tagcal/estimate/advice.hpp"

#include <gtest/gtest.h>

#include "calibrations.hpp"
#include "fresh_noise.hpp"
#include "tagcal/estimate/bundle/lack_of_fit.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
using namespace internal;
namespace {

WorldOptions flat_views(double max_tilt_deg) {
  WorldOptions options;
  options.num_views = 6;
  options.max_tilt_deg = max_tilt_deg;
  return options;
}

const Lens kLens = pinhole(900, 900, 639.5, 399.5);

TEST(Advice, NearlyFrontalViewsNeedATilt) {
  const Dataset world = make_world(kLens, 3, flat_views(4));
  const Calibration c = calibrate(world, with_model("f", 0.2));
  const auto view = advise(world, c);
  ASSERT_TRUE(view.has_value());
  EXPECT_GT(view->tilt_rad, 0.5);
  EXPECT_LT(view->focal_sigma_px, 0.5 * view->focal_sigma_now_px);
  EXPECT_NE(view->sentence.find("tilted by"), std::string::npos);
}

// A world whose origin is far from the board changes no distance to it.
TEST(Advice, TheDistanceIsThatOfTheBoard) {
  Dataset world = make_world(kLens, 3, flat_views(4));
  const auto here = advise(world, calibrate(world, with_model("f", 0.2)));
  world.boards[0].world_from_board = Pose(Eigen::Quaterniond::Identity(), {10, 0, 0});
  const auto there = advise(world, calibrate(world, with_model("f", 0.2)));
  ASSERT_TRUE(here && there);
  EXPECT_NEAR(there->distance_m, here->distance_m, 1e-6 * here->distance_m);
}

TEST(Advice, TheExpectedDeviationIsTheOneAfterwards) {
  Dataset world = make_world(kLens, 3, flat_views(15));
  const Calibration before = calibrate(world, with_model("f", 0.2));
  const auto view = advise(world, before);
  ASSERT_TRUE(view.has_value());
  EXPECT_NEAR(view->focal_sigma_now_px, before.sigmas[0], 1e-9 * before.sigmas[0]);
  Random random(3);
  WorldOptions options;
  world.views.push_back(observe({kLens, world.image_size}, view->camera_from_board,
                                target_points(world.boards[0].board), options, random));
  world.views.back().image = "advised.png";
  const Calibration after = calibrate(world, with_model("f", 0.2));
  // The expectation leaves out that the views share a board whose shape is not known.
  EXPECT_GT(after.sigmas[0] / view->focal_sigma_px, 0.9);
  EXPECT_LT(after.sigmas[0] / view->focal_sigma_px, 1.4);
  EXPECT_LT(after.sigmas[0], 0.9 * before.sigmas[0]);
}

// Random views leave a larger standard deviation than the advised one.
TEST(Advice, RandomViewsAreNoBetter) {
  const Dataset world = make_world(opencv5_lens(), 5, flat_views(30));
  const Calibration c = calibrate(world, with_model("opencv5", 0.2));
  const auto advised = advise(world, c);
  ASSERT_TRUE(advised.has_value());
  const auto after = [&](const Pose& pose) {
    Dataset more = world;
    Random random(9);
    more.views.push_back(observe({opencv5_lens(), world.image_size}, pose,
                                 target_points(world.boards[0].board), {}, random));
    more.views.back().image = "more.png";
    return calibrate(more, with_model("opencv5", 0.2)).sigmas[0];
  };
  const double with_advised = after(advised->camera_from_board);
  EXPECT_LT(with_advised, c.sigmas[0]);
  EXPECT_LT(advised->focal_sigma_px, c.sigmas[0]);
  Random random(4);
  for (int i = 0; i < 3; ++i)  // frontal views at the usual distance
    EXPECT_LT(with_advised, after(looking_at_board({0.33, 0.33, 0}, 0.05, 1.1, random)));
}

TEST(Advice, AssumesANominalFocalLengthIfThereIsNone) {
  WorldOptions options = flat_views(0);
  const Dataset world = make_world(kLens, 3, options);
  const Calibration c = calibrate(world);
  ASSERT_EQ(c.model, "weak");
  const auto view = advise(world, c);
  ASSERT_TRUE(view.has_value());
  EXPECT_GT(view->tilt_rad, 0.3);
  EXPECT_LT(view->focal_sigma_px, 128);  // a tenth of the nominal one: it would not be refused
  EXPECT_FALSE(advise(world, Calibration()).has_value());
}

TEST(Advice, CovariancesOfCornersGiveTheSameAdvice) {
  Dataset world = make_world(kLens, 3, flat_views(15));
  CalibrateOptions unstated;
  unstated.model = "f";
  const auto stated = advise(world, calibrate(world, with_model("f", 0.2)));
  for (View& view : world.views)
    for (Observation& o : view.observations) o.covariance_px2 = Matrix2(0.04 * Matrix2::Identity());
  const Calibration c = calibrate(world, unstated);
  EXPECT_TRUE(c.sigma_of_corners);
  const auto own = advise(world, c);
  ASSERT_TRUE(stated && own);
  EXPECT_NEAR(own->focal_sigma_px / stated->focal_sigma_px, 1, 0.1);
}

TEST(SelectedViews, DeviationsAreInflatedAsThoseOfTheAnswer) {
  const Dataset world = make_world(opencv5_lens(), 5);
  Calibration c = calibrate(world, with_model("opencv5", 0.2));
  c.variance_inflation = 1;
  const ViewSelection before = select_views(world, c, 20);
  c.variance_inflation = 4;
  const ViewSelection after = select_views(world, c, 20);
  EXPECT_NEAR(after.all_px, 2 * before.all_px, 1e-9 * after.all_px);
  ASSERT_EQ(after.views.size(), before.views.size());
  for (std::size_t i = 0; i < after.views.size(); ++i)
    EXPECT_EQ(after.views[i].view, before.views[i].view);
  EXPECT_NEAR(after.views.back().projection_px, after.all_px, 1e-9 * after.all_px);
}

TEST(WeakDirections, FocalLengthAndDistance) {
  // Few and nearly frontal views.
  const Calibration c = calibrate(make_world(kLens, 3, flat_views(5)), with_model("f", 0.2));
  ASSERT_EQ(c.weak_directions.size(), 1u);
  EXPECT_EQ(c.weak_directions[0].parameter, "f");
  EXPECT_NE(c.weak_directions[0].sentence.find("focal length from distance"), std::string::npos);
  const double f_px = c.sigmas[0] / 900;
  EXPECT_LT(c.weak_directions[0].sigma_px, f_px * std::hypot(640, 400));
  EXPECT_GT(c.weak_directions[0].sigma_px, 0.1 * f_px * 640);
}

TEST(WeakDirections, SumUpToTheProjectionVariance) {
  const Bundle exact = exact_bundle(Model::named("radial1"),
                                    Perspective({900, 900, 651, 392, -0.1}), 3, flat_views(40));
  const auto samples = seen_region(exact).samples();
  const UncertainCamera lens{
      exact.model, {exact.lens(), exact.image_size}, covariance_for(exact, 0.2)};
  double sum = 0;
  const auto directions = weak_directions(lens, samples);
  ASSERT_EQ(directions.size(), 3u);
  for (const WeakDirection& d : directions) sum += d.sigma_px * d.sigma_px;
  const double all =
      projection_uncertainty(lens, {exact.image_size}, samples, kInfinitelyFar).region_px;
  EXPECT_LE(sum, all * all * (1 + 1e-9));
  EXPECT_GT(sum, 0.9 * all * all);  // three of four directions have nearly all variance
  EXPECT_GE(directions[0].sigma_px, directions[1].sigma_px);
}

// With the right model the ratio is the largest of three (RMS at two distances, and of all
// parameters) whose mean squares are 1, and false alarms are rare.
TEST(Halves, AgreeWhereTheModelIsRight) {
  WorldOptions options;
  options.num_views = 8;
  const Bundle exact =
      exact_bundle(Model::named("radial1"), Perspective({900, 900, 651, 392, -0.1}), 3, options);
  const auto samples = seen_region(exact).samples();
  constexpr int kSolves = 200;
  double sum = 0;
  int alarms = 0;
  for (int i = 0; i < kSolves; ++i) {
    Bundle noisy = with_noise(exact, 0.2, Random(5, static_cast<std::uint64_t>(i)));
    ASSERT_TRUE(solve(noisy, 50).converged);
    const auto check = split_half_check(noisy, *bundle_information(noisy), 0.2, samples, 1.0);
    ASSERT_TRUE(check.has_value());
    sum += check->ratio * check->ratio;
    alarms += check->disagree;
  }
  EXPECT_GT(sum / kSolves, 1);
  EXPECT_LT(sum / kSolves, 2);
  EXPECT_LE(alarms, 1);
}

TEST(ResidualBias, IsSilentWhereTheModelIsRight) {
  WorldOptions options;
  options.num_views = 8;
  const Bundle exact =
      exact_bundle(Model::named("radial1"), Perspective({900, 900, 651, 392, -0.1}), 3, options);
  int alarms = 0;
  for (int i = 0; i < 200; ++i) {
    Bundle noisy = with_noise(exact, 0.2, Random(6, static_cast<std::uint64_t>(i)));
    solve(noisy, 50);
    alarms += residual_bias(noisy, 0.01).disagree;
  }
  EXPECT_LE(alarms, 1);
}

TEST(ResidualBias, ShowsAModelThatIsTooSmall) {
  WorldOptions options;
  options.num_views = 8;
  options.min_distance_m = 0.6;
  const Lens lens = Perspective({900, 900, 651, 392, -0.1, 0.1});
  const Bundle exact = exact_bundle(Model::named("radial2"), lens, 3, options);
  for (int i = 0; i < 5; ++i) {
    Bundle noisy = with_noise(exact, 0.2, Random(6, static_cast<std::uint64_t>(i)));
    solve(noisy, 50);
    EXPECT_FALSE(residual_bias(noisy, 0.01).disagree);
    noisy.model = &Model::named("radial1");
    noisy.free_values.pop_back();
    solve(noisy, 50);
    const ResidualBias bias = residual_bias(noisy, 0.01);
    EXPECT_TRUE(bias.disagree);
    EXPECT_GT(bias.rms_px, 0.05);
    EXPECT_LT(bias.rms_px, 0.5);
    EXPECT_FALSE(residual_bias(noisy, 50).disagree);  // below the floor of the noise
  }
}

}  // namespace
}  // namespace tagcal
