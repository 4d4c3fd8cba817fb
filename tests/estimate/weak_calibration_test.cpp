#include <gtest/gtest.h>

#include "spoiled_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"

// Model weak, asked for by its name: a scaled orthographic pose for each view.

namespace tagcal {
namespace {

constexpr double kFarFocal = 1'500'000;  // so far away that nothing is left of perspective

WorldOptions far_away() {
  WorldOptions options;
  options.num_views = 8;
  options.min_tilt_deg = 15;
  options.max_tilt_deg = 50;
  options.min_distance_m = 1500;
  options.max_distance_m = 2000;
  return options;
}

CalibrateOptions weak(double sigma_px = 0) {
  CalibrateOptions options;
  options.model = "weak";
  options.sigma_px = sigma_px;
  return options;
}

SpoiledWorld far_world(int seed) {
  return untouched(make_world(centred_pinhole(kFarFocal), seed, far_away()));
}

// The rotation that is nearer to the truth, of the two that a plane has.
double rotation_error(const CalibratedView& view, const Pose& truth, Pose& nearer) {
  nearer = view.camera_from_world;
  const double one = angle_between_rad(view.camera_from_world, truth);
  if (!view.mirrored) return one;
  const double other = angle_between_rad(*view.mirrored, truth);
  if (other < one) nearer = *view.mirrored;
  return std::min(one, other);
}

void expect_poses(const Calibration& c, const Truth& truth, double bound) {
  for (const CalibratedView& view : c.views) {
    const Pose& exact = truth.camera_from_world.at(view.image);
    Pose nearer;
    const double sd = std::sqrt(view.covariance.diagonal().head<3>().sum());
    EXPECT_LT(rotation_error(view, exact, nearer), bound * sd) << view.image;
    ASSERT_TRUE(view.scale_px_per_m.has_value());
    // The board's middle: where s is f / Z.
    const double scale = kFarFocal / (exact * Eigen::Vector3d(0.33, 0.33, 0)).z();
    EXPECT_NEAR(*view.scale_px_per_m, scale, bound * view.scale_sigma_px_per_m + 1e-3 * scale);
    EXPECT_TRUE(std::isnan(view.covariance(5, 5)));
  }
}

TEST(WeakCalibration, IsAnAnswerWithoutAFocalLength) {
  for (int seed = 1; seed <= 5; ++seed) {
    const Dataset world = far_world(seed).dataset;
    const Calibration c = calibrate(world, weak());
    EXPECT_EQ(c.status, Status::ok);
    EXPECT_EQ(c.model, "weak");
    EXPECT_TRUE(c.outliers.empty());
    EXPECT_TRUE(c.findings.empty());
    EXPECT_EQ(c.views.size(), 8u);
    EXPECT_NEAR(c.sigma_px, 0.2, 0.02);
    EXPECT_TRUE(c.projection.empty());
    expect_poses(c, *world.truth, 4);
    for (const CalibratedView& view : c.views) EXPECT_TRUE(view.mirrored.has_value());
    EXPECT_EQ(calibrate(world).status, Status::focal_not_observable);  // no one asked for weak
  }
}

TEST(WeakCalibration, StandardDeviationsAreThoseOfTheErrors) {
  double sum = 0, scale_sum = 0;
  int count = 0;
  for (int seed = 1; seed <= 40; ++seed) {
    const Dataset world = far_world(seed).dataset;
    for (const CalibratedView& view : calibrate(world, weak(0.2)).views) {
      const Pose& exact = world.truth->camera_from_world.at(view.image);
      Pose nearer;
      rotation_error(view, exact, nearer);
      if (nearer.matrix() != view.camera_from_world.matrix()) continue;  // the covariance's own
      const Eigen::Vector3d error = minus(nearer, exact).head<3>();
      sum += error.dot(Eigen::Matrix3d(view.covariance.topLeftCorner<3, 3>()).ldlt().solve(error));
      // The scale of the corners' centroid and of the board's middle differ by far less.
      const double scale = kFarFocal / (exact * Eigen::Vector3d(0.33, 0.33, 0)).z();
      scale_sum += std::pow((*view.scale_px_per_m - scale) / view.scale_sigma_px_per_m, 2);
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_NEAR(sum / (3 * count), 1, 4 * std::sqrt(2.0 / (3 * count)));
  EXPECT_LT(scale_sum / count, 1.5);
}

TEST(WeakCalibration, WrongCornersAreLeftOut) {
  for (const double reach_px : {0.0, 20.0}) {
    SpoiledWorld world = far_world(3);
    Random random(3);
    spoil_corners(world, 0.2, reach_px, random);
    permute(world, 2, swapping(5, 30));
    const Calibration c = calibrate(world.dataset, weak());
    ASSERT_EQ(c.status, Status::ok);
    std::set<CornerName> out;
    for (const Outlier& o : c.outliers) {
      out.insert({o.image, o.id});
      EXPECT_GT(o.residual_px, 0.9);
    }
    for (const CornerName& name : world.wrong) EXPECT_TRUE(out.contains(name));
    EXPECT_LE(out.size(), world.wrong.size() + 4);
    expect_poses(c, *world.dataset.truth, 4);
  }
}

TEST(WeakCalibration, NoiseHasNoConsensus) {
  WorldOptions noise = far_away();
  noise.outlier_share = 1;
  for (int seed = 1; seed <= 3; ++seed) {
    const Dataset world = make_world(centred_pinhole(kFarFocal), seed, noise);
    EXPECT_FALSE(is_answer(calibrate(world, weak()).status));
  }
}

TEST(WeakCalibration, CornersCovariancesCount) {
  Dataset world = far_world(4).dataset;
  Random random(4);
  for (View& view : world.views)
    for (Observation& o : view.observations) {
      const double sigma = random.uniform() < 0.5 ? 0.2 : 2.0;
      if (sigma > 1) o.pixel += 2.0 * Eigen::Vector2d(random.normal(), random.normal());
      o.covariance_px2 = Matrix2(sigma * sigma * Eigen::Matrix2d::Identity());
    }
  const Calibration c = calibrate(world, weak());
  EXPECT_TRUE(c.sigma_of_corners);
  EXPECT_TRUE(c.outliers.empty());
  expect_poses(c, *world.truth, 4);
  const Calibration unweighted = calibrate(world, weak(1.4));
  EXPECT_LT(c.views[0].scale_sigma_px_per_m, 0.5 * unweighted.views[0].scale_sigma_px_per_m);
}

TEST(WeakCalibration, TooLittleIsDegenerate) {
  Dataset world = far_world(5).dataset;
  world.views.resize(1);
  world.views[0].observations.resize(6);
  EXPECT_EQ(calibrate(world, weak()).status, Status::degenerate);
  CalibrateOptions bent = weak();
  bent.board_warp = true;
  EXPECT_THROW(calibrate(world, bent), Error);
}

}  // namespace
}  // namespace tagcal
