#include "tagcal/estimate/calibration/model_error.hpp"

#include <gtest/gtest.h>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

// Corners as a detector tells them: with their own noise, from 0.005 to 0.03 px, and what it does
// not know of.
Dataset world_with_model_error(double error_px, std::uint64_t seed) {
  WorldOptions options;
  options.sigma_px = 0;
  Dataset world = make_world(opencv5_lens(), seed, options);
  Random random(1000 + seed);
  for (View& view : world.views) {
    for (Observation& o : view.observations) {
      const double own = random.uniform(0.005, 0.03);
      o.pixel += std::hypot(own, error_px) * Vector2d(random.normal(), random.normal());
      o.covariance_px2 = Matrix2(own * own * Matrix2::Identity());
    }
  }
  return world;
}

CalibrateOptions opencv5_options() {
  CalibrateOptions options;
  options.model = "opencv5";
  return options;
}

TEST(ModelError, IsWhatTheCornersOwnNoiseDoesNotExplain) {
  for (const double error_px : {0.02, 0.1, 1.0}) {
    const Calibration c = calibrate(world_with_model_error(error_px, 1), opencv5_options());
    EXPECT_EQ(c.status, Status::ok);
    EXPECT_TRUE(c.sigma_of_corners);
    EXPECT_NEAR(c.model_error_px, error_px, 0.06 * error_px);
    EXPECT_TRUE(c.findings.empty()) << c.findings.front().sentence;
  }
  const Calibration automatic = calibrate(world_with_model_error(0.1, 1));
  EXPECT_EQ(automatic.model, "opencv4");
  EXPECT_NEAR(automatic.model_error_px, 0.1, 0.006);
}

TEST(ModelError, IsNoneWhereNoiseExplainsTheResiduals) {
  for (int seed = 1; seed <= 20; ++seed)
    EXPECT_EQ(
        calibrate(world_with_model_error(0, static_cast<std::uint64_t>(seed)), opencv5_options())
            .model_error_px,
        0)
        << seed;
}

TEST(ModelError, CountsInTheCovariance) {
  double squares = 0;
  constexpr int kSeeds = 100;
  const Model& model = Model::named("opencv5");
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Calibration c = calibrate(world_with_model_error(0.05, static_cast<std::uint64_t>(seed)),
                                    opencv5_options());
    ASSERT_EQ(c.status, Status::ok);
    squares += normalised_squared_error(model, c.camera->lens, opencv5_lens(), c.covariance);
  }
  // A mean of 100 x 9 squared normal deviates: sd 0.047.
  EXPECT_NEAR(squares / (kSeeds * model.num_free()), 1, 0.15);
}

TEST(ModelError, CornersWithoutCovarianceAmongOthersCountLittle) {
  Dataset world = world_with_model_error(0, 3);
  int dropped = 0;
  for (View& view : world.views) {
    for (Observation& o : view.observations) {
      if (++dropped % 3 != 0) continue;
      o.covariance_px2.reset();
      o.pixel += Vector2d(0.4, -0.3);  // they are off, and nothing says so
    }
  }
  const Calibration c = calibrate(world, opencv5_options());
  ASSERT_EQ(c.status, Status::ok);
  EXPECT_TRUE(c.sigma_of_corners);
  ASSERT_FALSE(c.findings.empty());
  EXPECT_NE(c.findings.front().sentence.find("0.5 px of noise is assumed"), std::string::npos);
  const Lens truth = opencv5_lens();
  for (std::size_t i = 0; i < c.sigmas.size(); ++i)
    EXPECT_LE(std::abs(parameters(c.camera->lens)[i] - parameters(truth)[i]), 5 * c.sigmas[i]) << i;
  for (View& view : world.views)
    for (std::size_t i = 0; i < view.observations.size(); ++i)
      if (i % 4 != 0) view.observations[i].covariance_px2.reset();
  EXPECT_FALSE(calibrate(world, opencv5_options()).sigma_of_corners);  // too few have one
}

TEST(ExcessPx, IsTheMomentEstimate) {
  Random random(5);
  std::vector<Vector2d> residuals;
  std::vector<Matrix2> covariances;
  for (int i = 0; i < 20000; ++i) {
    const Vector2d sd(random.uniform(0.01, 0.1), random.uniform(0.01, 0.1));
    residuals.emplace_back(std::hypot(sd.x(), 0.07) * random.normal(),
                           std::hypot(sd.y(), 0.07) * random.normal());
    covariances.emplace_back(Vector2d(sd.cwiseAbs2()).asDiagonal());
  }
  EXPECT_NEAR(excess_px(residuals, covariances, 40000), 0.07, 0.001);
  EXPECT_EQ(excess_px({}, {}, 0), 0);
}

}  // namespace
}  // namespace tagcal
