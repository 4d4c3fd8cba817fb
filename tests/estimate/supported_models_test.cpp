// What a choice of the model leaves out is part of what is claimed.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

WorldOptions six_views() {
  WorldOptions options;
  options.num_views = 6;
  options.min_distance_m = 0.9;
  options.max_distance_m = 1.4;
  options.sigma_px = 0.3;
  return options;
}

Lens wide_pinhole() { return pinhole(400, 400, 651, 392); }

// The largest error over the image at infinity, in claimed standard deviations.
double worst_in_image(const Camera& truth, const Calibration& c) {
  const ProjectionUncertainty& claimed = c.projection.front();
  const auto d = lens_difference(truth, *c.camera, c.seen.samples(), kInfinitelyFar);
  double worst = 0;
  for (int row = 0; d && row < claimed.grid.rows; ++row) {
    for (int column = 0; column < claimed.grid.columns; ++column) {
      const double sigma = claimed.sigma_px(row, column);
      const double error = std::hypot(d->u_px(row, column), d->v_px(row, column));
      if (std::isfinite(sigma)) worst = std::max(worst, error / (std::sqrt(2) * sigma));
    }
  }
  return worst;
}

// Distortions between what no one sees and what everyone does: the corners do not tell which model
// made them, and many are answered by one that is too small.
TEST(SupportedModels, CountInWhatIsClaimed) {
  int too_small = 0, answers = 0;
  double squares = 0;
  for (const double k1 : {-0.001, -0.002, -0.004, -0.008}) {
    for (int seed = 1; seed <= 15; ++seed) {
      const Dataset world = make_world(Perspective({900, 900, 651, 392, k1}), seed, six_views());
      const Calibration c = calibrate(world);
      ASSERT_EQ(c.status, Status::ok) << k1 << " " << seed;
      ++answers;
      too_small += c.model == "f" || c.model == "f+c" || c.model == "pinhole";
      const double ratio = (parameters(c.camera->lens)[0] - 900) / c.sigmas[0];
      EXPECT_LT(std::abs(ratio), 5) << k1 << " " << seed << " " << c.model;
      EXPECT_LT(worst_in_image(world.truth->camera, c), 5) << k1 << " " << seed << " " << c.model;
      squares += ratio * ratio;
    }
  }
  EXPECT_GT(too_small, 10);
  // Neither too bold nor inflated.
  EXPECT_LT(squares / answers, 1.7);
  EXPECT_GT(squares / answers, 0.3);
}

TEST(SupportedModels, WeightsAddUpToOne) {
  const Calibration c =
      calibrate(make_world(Perspective({900, 900, 651, 392, -0.002}), 3, six_views()));
  double sum = 0;
  for (const ModelStep& step : c.steps) {
    EXPECT_GE(step.weight, 0) << step.model;
    sum += step.weight;
  }
  EXPECT_NEAR(sum, 1, 1e-9);
}

// Of a rational lens whose coefficients the data do not locate, rounding decides where the solver
// stops. What is claimed must not depend on that.
TEST(SupportedModels, RoundingOfTheCornersChangesNoClaim) {
  int rational = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    const Dataset world = make_world(opencv5_lens(), seed, six_views());
    Dataset rounded = world;
    for (View& view : rounded.views)
      for (Observation& o : view.observations) o.pixel *= 1 + 1e-13;
    const Calibration a = calibrate(world), b = calibrate(rounded);
    ASSERT_EQ(a.model, b.model) << seed;
    for (const ModelStep& step : a.steps) rational += step.model == "opencv8" && step.weight > 0;
    for (std::size_t i = 0; i < a.projection.size(); ++i) {
      EXPECT_NEAR(a.projection[i].region_px / b.projection[i].region_px, 1, 0.02) << seed;
      EXPECT_EQ(a.projection[i].sigma_px.array().isNaN().count(),
                b.projection[i].sigma_px.array().isNaN().count())
          << seed;
    }
  }
  EXPECT_GT(rational, 0);
}

// A plain lens leaves the numerator and denominator of a rational one free along a valley: its
// covariance, nearly singular, is one all the same.
TEST(SupportedModels, ARationalLensOfPlainDataHasACovariance) {
  WorldOptions options;
  options.num_views = 29;
  options.sigma_px = 0.012;
  for (int seed = 1; seed <= 20; ++seed) {
    CalibrateOptions rational;
    rational.model = "opencv8";
    const Calibration c = calibrate(make_world(wide_pinhole(), seed, options), rational);
    ASSERT_EQ(c.status, Status::ok) << seed;
    const Eigen::VectorXd sigmas = c.covariance.diagonal().cwiseSqrt();
    ASSERT_TRUE((sigmas.array() > 0).all()) << seed;
    const Eigen::MatrixXd unit =
        sigmas.cwiseInverse().asDiagonal() * c.covariance * sigmas.cwiseInverse().asDiagonal();
    EXPECT_LT((unit - unit.transpose()).cwiseAbs().maxCoeff(), 1e-12) << seed;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(unit).eigenvalues()[0], -1e-12)
        << seed;
  }
}

TEST(HasPole, WhereTheDenominatorVanishesWithinTheImage) {
  const auto camera = [](double k4) {
    return Camera{Perspective({900, 900, 639.5, 399.5, 0, 0, 0, 0, 0, k4, 0, 0}), {1280, 800}};
  };
  // The corners are at radius 0.838: 1 + k4 r^2 = 0 there for k4 = -1.42.
  EXPECT_TRUE(has_pole(camera(-1.45)));
  EXPECT_FALSE(has_pole(camera(0.3)));
  EXPECT_FALSE(has_pole(camera(0)));
  EXPECT_FALSE(has_pole({opencv5_lens(), {1280, 800}}));
  EXPECT_FALSE(has_pole({fisheye_lens(), {1280, 800}}));
}

}  // namespace
}  // namespace tagcal
