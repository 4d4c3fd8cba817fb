#include <gtest/gtest.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

const ModelStep& step_of(const Calibration& c, const std::string& model) {
  for (const ModelStep& step : c.steps)
    if (step.model == model) return step;
  static const ModelStep none;
  ADD_FAILURE() << "no step " << model;
  return none;
}

std::string ladder_of(const Calibration& c) {
  std::string text;
  for (const ModelStep& step : c.steps)
    text += "\n  " + step.model + " " + std::to_string(step.bic) + " " + step.sentence;
  return text;
}

WorldOptions few_views(int num_views = 8) {
  WorldOptions options;
  options.num_views = num_views;
  options.min_distance_m = 0.6;
  options.max_distance_m = 1.2;
  return options;
}

WorldOptions near_fisheye() {
  WorldOptions options = few_views();
  options.min_distance_m = 0.35;
  options.max_distance_m = 0.8;
  return options;
}

const std::vector<std::pair<std::string, Lens>>& truths() {
  static const std::vector<std::pair<std::string, Lens>> all = {
      {"f", pinhole(900, 900, 639.5, 399.5)},
      {"f+c", pinhole(900, 900, 651, 392)},
      {"pinhole", pinhole(900, 896, 651, 392)},
      {"radial1", Perspective({900, 900, 651, 392, -0.1})},
      {"radial2", Perspective({900, 900, 651, 392, -0.2, 0.08})},
      {"opencv4", opencv5_lens()},
      {"opencv5", Perspective({900, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0.08})},
      {"opencv8", Perspective({500, 501, 651, 392, 0.5, 0.1, 5e-4, -3e-4, 0.01, 0.8, 0.15, 0.02})},
      {"fisheye4", fisheye_lens()}};
  return all;
}

// A fit of a larger model may stop far from its minimum, with outliers everywhere. (A perspective
// lens before a fisheye's corners did: its smaller sibling then had a negative chi-square.)
TEST(Selection, AFitThatLeavesAStuckOneHasItsOwnSquares) {
  using namespace internal;
  const CalibrationInput input = calibration_input(make_world(opencv5_lens(), 1, few_views()), {});
  const Model& model = Model::named("opencv5");
  const auto fit = fit_model(model, input, {});
  ASSERT_TRUE(fit);
  CalibrationFit stuck = *fit;
  for (auto& of_view : stuck.squares) std::ranges::fill(of_view, 1e8);
  stuck.summary.cost = 1e8 * static_cast<double>(fit->num_corners);
  const double sigma = fit->bundle.sigma;
  const auto values = model.free_values(fit->bundle.lens());
  const CalibrationFit again = fit_on_inliers(std::move(stuck), model, values, {});
  EXPECT_NEAR(again.truncated_chi_square(sigma) / fit->truncated_chi_square(sigma), 1, 1e-3);
}

TEST(Selection, TheModelThatMadeTheData) {
  for (const auto& [model, lens] : truths()) {
    const bool wide = model == "opencv8" || model == "fisheye4";
    for (int seed = 1; seed <= 3; ++seed) {
      const Calibration c = calibrate(make_world(lens, seed, wide ? near_fisheye() : few_views()));
      EXPECT_EQ(c.status, Status::ok) << model;
      EXPECT_GT(c.seconds.start, 0);
      EXPECT_GE(c.steps.size(), 9u) << ladder_of(c);
      // A rational lens with a pole in the image is not taken, whatever the corners ask for: then
      // it counts in what is claimed.
      const ModelStep& step = step_of(c, model);
      const bool has_pole = step.sentence.find("a pole inside the image") != std::string::npos;
      if (model == "opencv8" && has_pole) {
        EXPECT_EQ(c.model, "opencv5");
        EXPECT_GT(step.weight, 0.5) << ladder_of(c);
        continue;
      }
      EXPECT_EQ(c.model, model) << "seed " << seed << ladder_of(c);
      EXPECT_TRUE(step.taken);
      EXPECT_FALSE(step_of(c, "weak").taken);
      for (const ModelStep& any : c.steps) EXPECT_FALSE(any.sentence.empty()) << any.model;
    }
  }
}

// So many corners that BIC sees a coefficient which moves no corner by a third of a pixel: it is
// taken, but not where a tolerance leaves it out; then what it changes counts.
TEST(Selection, AToleranceLeavesOutWhatNoSceneNeeds) {
  WorldOptions options = few_views(12);
  options.sigma_px = 0.02;
  const Dataset world = make_world(Perspective({900, 900, 651, 392, -0.001}), 5, options);
  const Calibration best = calibrate(world);
  EXPECT_EQ(best.model, "radial1");
  CalibrateOptions tolerant;
  tolerant.tolerance_px = 0.1;
  const Calibration c = calibrate(world, tolerant);
  EXPECT_EQ(c.model, "f+c");
  EXPECT_LT(step_of(c, "radial1").bic, step_of(c, "f+c").bic - 10);
  EXPECT_FALSE(step_of(c, "radial1").taken);
  double counted = 0;
  for (const ModelStep& step : c.steps) counted += step.weight;
  EXPECT_GT(counted, 0.99);
  EXPECT_GT(step_of(c, "f+c").difference_px.value(), 0.01);
  EXPECT_LT(step_of(c, "f+c").difference_px.value(), 0.1);
  EXPECT_GT(c.sigmas[0], best.sigmas[0]);
  EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 900), 4 * c.sigmas[0]);
  // Over the whole image: the coefficient that is left out is within what is claimed.
  const ProjectionUncertainty& at_infinity = c.projection.front();
  const auto d = lens_difference(world.truth->camera, *c.camera, c.seen.samples(), kInfinitelyFar);
  ASSERT_TRUE(d.has_value());
  for (int row = 0; row < at_infinity.grid.rows; ++row)
    for (int column = 0; column < at_infinity.grid.columns; ++column)
      if (!std::isnan(at_infinity.sigma_px(row, column))) {
        EXPECT_LT(std::hypot(d->u_px(row, column), d->v_px(row, column)),
                  5 * std::sqrt(2) * at_infinity.sigma_px(row, column));
      }
  tolerant.model = "f";
  EXPECT_THROW(calibrate(world, tolerant), Error);
}

TEST(Selection, ALongLensFarAwayIsWeak) {
  WorldOptions options;
  options.num_views = 5;
  options.min_distance_m = 400;
  options.max_distance_m = 420;
  for (int seed = 1; seed <= 3; ++seed) {
    const Dataset world = make_world(pinhole(300'000, 300'000, 639.5, 399.5), seed, options);
    const Calibration c = calibrate(world);
    EXPECT_EQ(c.status, Status::focal_not_observable);
    EXPECT_EQ(c.model, "weak");
    EXPECT_TRUE(step_of(c, "weak").taken);
    EXPECT_FALSE(step_of(c, "f").taken);
    EXPECT_NEAR(c.rms_px, 0.2 * std::sqrt(2.0), 0.03);
    ASSERT_EQ(c.views.size(), 5u);
    for (const CalibratedView& view : c.views) {
      const Pose& truth = world.truth->camera_from_world.at(view.image);
      const double depth = (truth * Eigen::Vector3d(0.33, 0.33, 0)).z();
      ASSERT_TRUE(view.scale_px_per_m.has_value());
      EXPECT_NEAR(*view.scale_px_per_m * depth / 300'000, 1, 2e-3);
    }
  }
}

TEST(Selection, AFocalLengthThatIsKnownIsNotRefused) {
  // One tilted view holds f, and no more.
  WorldOptions options;
  options.num_views = 1;
  options.min_tilt_deg = 30;
  for (int seed = 1; seed <= 10; ++seed) {
    const Calibration c = calibrate(make_world(pinhole(900, 900, 639.5, 399.5), seed, options));
    EXPECT_EQ(c.status, Status::ok) << seed;
    EXPECT_EQ(c.model, "f");
    EXPECT_FALSE(step_of(c, "opencv5").taken);
  }
}

// One view of a lens whose centre is far off: f alone does not explain it, f+c is not determined. A
// model that does not explain the corners refuses none that does.
TEST(Selection, OnlyAModelThatExplainsTheCornersRefuses) {
  WorldOptions options;
  options.num_views = 1;
  options.min_tilt_deg = 30;
  options.sigma_px = 0.05;
  for (int seed = 1; seed <= 10; ++seed) {
    const Calibration c =
        calibrate(make_world(Perspective({900, 900, 700, 340, -0.2}), seed, options));
    if (!is_answer(c.status)) {
      EXPECT_FALSE(c.findings.empty());
      EXPECT_TRUE(c.projection.empty());
      EXPECT_FALSE(c.halves.has_value());
      continue;
    }
    EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 900), 5 * c.sigmas[0]) << seed << c.model;
  }
}

// Corners so exact that rejection stops at its floor, with a tail: what one lens rejects and the
// other keeps must not decide between them.
TEST(Selection, ExactCornersWithATailArePinholes) {
  WorldOptions options = few_views(8);
  options.sigma_px = 0.004;
  for (int seed = 1; seed <= 6; ++seed) {
    Dataset world = make_world(pinhole(900, 900, 639.5, 399.5), seed, options);
    Random random(11, static_cast<std::uint64_t>(seed));
    for (View& view : world.views)
      for (Observation& o : view.observations)
        if (random.uniform() < 0.02)
          o.pixel += 0.03 * Eigen::Vector2d(random.normal(), random.normal());
    const Calibration c = calibrate(world);
    EXPECT_EQ(c.model, "f") << seed << ladder_of(c);
  }
}

// More views than are compared: the losers are not fitted to all of them, and the steps say so.
TEST(Selection, ManyViewsAreComparedOnAPartOfThemFirst) {
  for (const auto& [model, lens] : truths()) {
    if (model == "opencv8") continue;
    WorldOptions options = model == "fisheye4" ? near_fisheye() : few_views();
    options.num_views = 50;
    const Calibration c = calibrate(make_world(lens, 4, options));
    EXPECT_EQ(c.status, Status::ok) << model;
    EXPECT_EQ(c.model, model) << ladder_of(c);
    EXPECT_EQ(c.views.size(), 50u);
    const char* loser = model == "fisheye4" ? "f" : "fisheye4";
    EXPECT_FALSE(step_of(c, loser).taken) << model;
    EXPECT_GT(step_of(c, loser).bic, step_of(c, model).bic) << model;
  }
}

TEST(Selection, AnAskedModelHasNoSteps) {
  CalibrateOptions options;
  options.model = "f";
  EXPECT_TRUE(calibrate(make_world(pinhole(900, 900, 639.5, 399.5), 1, few_views()), options)
                  .steps.empty());
}

}  // namespace
}  // namespace tagcal
