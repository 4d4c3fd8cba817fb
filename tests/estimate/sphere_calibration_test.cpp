#include <gtest/gtest.h>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

// Lenses of six parameters that see 195 degrees: double sphere and extended unified.

namespace tagcal {
namespace {

// The lens whose field of view over the diagonal of 1280 x 800 pixels is 195 degrees.
Lens wide_lens(std::vector<double> parameters, const LensKind& kind) {
  constexpr double kHalf = 97.5 * std::numbers::pi / 180;
  const auto edge = project(make_lens(kind, parameters), {std::sin(kHalf), 0, std::cos(kHalf)});
  parameters[0] = std::hypot(1280, 800) / 2 / edge->x();
  parameters[1] = 0.998 * parameters[0];
  parameters[2] = 645;
  parameters[3] = 395;
  return make_lens(kind, parameters);
}

Lens lens_of(const std::string& model) {
  return model == "ds" ? wide_lens({1, 1, 0, 0, -0.2, 0.6}, kind_of<DoubleSphere>())
                       : wide_lens({1, 1, 0, 0, 0.62, 1.08}, kind_of<ExtendedUnified>());
}

Dataset world(const std::string& model, std::uint64_t seed, double sigma_px) {
  WorldOptions options;
  options.sigma_px = sigma_px;
  options.min_distance_m = 0.12;
  options.max_distance_m = 0.5;
  options.max_tilt_deg = 60;
  return make_world(lens_of(model), seed, options);
}

class SphereCalibration : public testing::TestWithParam<const char*> {};

TEST_P(SphereCalibration, ParametersAreWithinTheirClaims) {
  constexpr int kSeeds = 12;
  double sum = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Dataset set = world(GetParam(), static_cast<std::uint64_t>(seed), 0.1);
    CalibrateOptions options;
    options.model = GetParam();
    const Calibration c = calibrate(set, options);
    ASSERT_EQ(c.status, Status::ok) << seed;
    sum += normalised_squared_error(Model::named(GetParam()), c.camera->lens,
                                    set.truth->camera.lens, c.covariance);
  }
  const double expected = 6 * kSeeds;  // a chi-square of so many degrees of freedom
  EXPECT_NEAR(sum, expected, 3.3 * std::sqrt(2 * expected));
}

// With good corners; with noise a fisheye of four coefficients may explain them as well.
TEST_P(SphereCalibration, AutoChoosesItOrProjectsAlike) {
  for (const double sigma_px : {0.001, 0.1}) {
    for (const std::uint64_t seed : {21, 22, 23}) {
      const Dataset set = world(GetParam(), seed, sigma_px);
      const Calibration c = calibrate(set, {});
      ASSERT_EQ(c.status, Status::ok) << seed;
      if (sigma_px < 0.01) {
        EXPECT_EQ(c.model, GetParam()) << seed;
      }
      const auto difference =
          lens_difference(*c.camera, set.truth->camera, c.seen.samples(), kInfinitelyFar);
      ASSERT_TRUE(difference.has_value());
      EXPECT_LT(difference->rms_px, 3 * std::sqrt(2.0) * c.projection.front().region_px) << seed;
    }
  }
}

TEST_P(SphereCalibration, ExactCornersGiveTheTruth) {
  const Dataset set = world(GetParam(), 5, 0);
  CalibrateOptions by_name;
  by_name.model = GetParam();
  const Calibration c = calibrate(set, by_name);
  ASSERT_EQ(c.status, Status::ok);
  const auto truth = parameters(set.truth->camera.lens);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(parameters(c.camera->lens)[i], truth[i], 1e-6 * std::max(1.0, std::abs(truth[i])));
}

INSTANTIATE_TEST_SUITE_P(Kinds, SphereCalibration, testing::Values("ds", "eucm"));

}  // namespace
}  // namespace tagcal
