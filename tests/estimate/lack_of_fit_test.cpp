// What a calibration says where its model, its noise or its views are not what they are taken for.

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "calibrations.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

std::string codes(const Calibration& c) {
  std::string all;
  for (const Finding& finding : c.findings) all += finding.code + " ";
  return all;
}

CalibrateOptions opencv5(double sigma_px = 0) {
  CalibrateOptions options;
  options.model = "opencv5";
  options.sigma_px = sigma_px;
  return options;
}

Dataset world_of(const Lens& lens, double sigma_px, std::uint64_t seed) {
  WorldOptions options;
  options.sigma_px = sigma_px;
  return make_world(lens, seed, options);
}

TEST(LackOfFit, AWorldAsStatedIsNotWarnedOf) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Calibration c = calibrate(world_of(opencv5_lens(), 0.2, seed), opencv5(0.2));
    ASSERT_EQ(c.status, Status::ok);
    for (const char* code : {"noise_understated", "residuals_biased", "halves_disagree"})
      EXPECT_FALSE(has(c, code)) << code << " " << seed;
  }
}

TEST(LackOfFit, NoiseLargerThanStatedIsSaid) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    EXPECT_TRUE(
        has(calibrate(world_of(opencv5_lens(), 0.5, seed), opencv5(0.2)), "noise_understated"));
}

// Moves the corners by a wave over the image, which no lens has: as of a bent cover glass.
void add_wave(double amplitude_px, Dataset& world) {
  for (View& view : world.views)
    for (Observation& o : view.observations) {
      const Vector2d phase = 2 * std::numbers::pi * o.pixel / 250;
      o.pixel += amplitude_px * Vector2d(std::sin(phase.y()), std::sin(phase.x()));
    }
}

// A third of the noise, which the means of 30 corners show.
TEST(LackOfFit, AWaveBelowTheNoiseIsSeen) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Dataset world = world_of(opencv5_lens(), 0.1, seed);
    add_wave(0.035, world);
    EXPECT_TRUE(has(calibrate(world, opencv5()), "residuals_biased")) << seed;
  }
}

TEST(LackOfFit, ResidualsThatDifferFromPlaceToPlaceAreSaid) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Dataset world = world_of(opencv5_lens(), 0.1, seed);
    const Calibration right = calibrate(world, opencv5());
    add_wave(0.12, world);
    const Calibration waved = calibrate(world, opencv5());
    ASSERT_TRUE(waved.camera.has_value());
    EXPECT_TRUE(has(waved, "residuals_biased")) << codes(waved);
    EXPECT_FALSE(has(right, "residuals_biased"));
    EXPECT_GT(waved.sigmas[0] / right.sigmas[0], waved.sigma_px / right.sigma_px) << seed;
  }
}

// The lens is focused anew for every second view: the claim covers both focal lengths, and it is
// said that the views disagree.
TEST(LackOfFit, HalvesOfTheViewsThatSeeAnotherFocalLengthAreSaid) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Dataset world = world_of(opencv5_lens(), 0.1, seed);
    auto parameters_of_other = std::get<Perspective>(opencv5_lens()).parameters();
    parameters_of_other[0] += 10;
    parameters_of_other[1] += 10;
    const Dataset other = world_of(Perspective(parameters_of_other), 0.1, seed);
    for (std::size_t i = 1; i < world.views.size(); i += 2) world.views[i] = other.views[i];
    CalibrateOptions options = opencv5(0.1);
    options.reject_outliers = false;  // nor views
    const Calibration c = calibrate(world, options);
    EXPECT_TRUE(has(c, "halves_disagree") || has(c, "rows_displaced")) << codes(c);
    EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 905), 3 * c.sigmas[0]) << seed;
    EXPECT_GT(c.variance_inflation, 1.5) << seed;
  }
}

// The pictures of two cameras, as one: the sources are compared, not every other view. At the
// distance of the board a motion of the camera replaces another focal length (seeds 1 to 3) or
// principal point (4 to 6); the latter is small beside what is known of the focal length.
TEST(LackOfFit, TwoCamerasThatArePooledAreSaid) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Dataset world = world_of(opencv5_lens(), 0.1, seed);
    auto parameters_of_other = std::get<Perspective>(opencv5_lens()).parameters();
    if (seed <= 3) {
      parameters_of_other[0] += 20;
      parameters_of_other[1] += 20;
    } else {
      parameters_of_other[2] += 5;
    }
    const Dataset other = world_of(Perspective(parameters_of_other), 0.1, seed);
    CalibrateOptions options = opencv5(0.1);
    options.reject_outliers = false;
    for (std::size_t i = 0; i < world.views.size(); ++i)
      options.sources.emplace_back(2 * i < world.views.size() ? "left" : "right");
    EXPECT_FALSE(has(calibrate(world, options), "sources_disagree")) << seed;
    for (std::size_t i = 0; i < world.views.size(); ++i)
      if (options.sources[i] == "right") world.views[i] = other.views[i];
    const Calibration c = calibrate(world, options);
    EXPECT_TRUE(has(c, "sources_disagree")) << codes(c);
    EXPECT_FALSE(has(c, "halves_disagree")) << codes(c);
    ASSERT_TRUE(c.halves);
    EXPECT_FALSE(c.halves->source.empty());
    options.sources.pop_back();
    EXPECT_THROW(calibrate(world, options), Error);
  }
}

// Sources too small to be compared with the others leave the views to be compared in turn.
TEST(LackOfFit, SmallSourcesLeaveTheHalves) {
  const Dataset world = world_of(opencv5_lens(), 0.1, 1);
  CalibrateOptions options = opencv5(0.1);
  for (std::size_t i = 0; i < world.views.size(); ++i)
    options.sources.push_back(i < 2 ? "few" : "many");
  const Calibration two = calibrate(world, options);
  ASSERT_TRUE(two.halves);
  EXPECT_EQ(two.halves->source, "");
  for (std::size_t i = 0; i < world.views.size(); ++i) options.sources[i] = std::to_string(i);
  const Calibration each = calibrate(world, options);
  ASSERT_TRUE(each.halves);
  EXPECT_EQ(each.halves->ratio, two.halves->ratio);
}

}  // namespace
}  // namespace tagcal
