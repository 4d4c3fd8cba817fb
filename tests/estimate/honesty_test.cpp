// What a calibration says of itself: answers, refusals and warnings with reason.

#include <gtest/gtest.h>

#include "calibrations.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"
#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

// Without distortion the rational lens' coefficients stand for each other, and no projection knows.
TEST(Honesty, CoefficientsThatTradeAreNoReasonToRefuse) {
  WorldOptions options;
  options.num_views = 5;
  const Lens lens = pinhole(900, 900, 639.5, 399.5);
  for (const double sigma : {0.0, 0.2}) {
    options.sigma_px = sigma;
    for (int seed = 1; seed <= 3; ++seed) {
      const Calibration c = calibrate(make_world(lens, seed, options), with_model("opencv8", 0.2));
      ASSERT_EQ(c.status, Status::ok) << sigma << " " << seed;
      EXPECT_NEAR(parameters(c.camera->lens)[0], 900, 4 * c.sigmas[0] + 1e-6);
      EXPECT_LT(c.projection.at(0).region_px, 1);
      // With noise the solver may stop far down the valley, where coefficients of thousands are
      // as determined as those of any rational lens.
      if (sigma > 0) continue;
      EXPECT_EQ(c.findings.at(0).code, "coefficients_correlated");
    }
  }
}

// One view, or ten of one pose, show little of a centre or a lens: priors do, and the claim is
// theirs. Frontal views have no focal length under any model.
void expect_within_claim(const Calibration& c, const std::string& where) {
  if (!is_answer(c.status)) return;
  EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 900), 3 * c.sigmas[0]) << where;
  EXPECT_LE(c.sigmas[0], 0.1 * parameters(c.camera->lens)[0]) << where;
}

TEST(Honesty, AFewViewsClaimWhatIsUsual) {
  WorldOptions one, frontal;
  one.num_views = 1;
  one.min_tilt_deg = 30;
  frontal.num_views = 3;
  frontal.max_tilt_deg = 0;
  const Lens lens = pinhole(900, 900, 639.5, 399.5);
  for (int seed = 1; seed <= 4; ++seed) {
    const Dataset tilted = make_world(lens, seed, one);
    for (const char* model : {"f", "f+c", "opencv5", "opencv8", "fisheye4"}) {
      const std::string where = model + std::string(" ") + std::to_string(seed);
      const Calibration c = calibrate(tilted, with_model(model));
      expect_within_claim(c, where);
      if (is_answer(c.status)) {
        EXPECT_TRUE(std::ranges::count(c.findings, "few_views", &Finding::code)) << where;
      }
      EXPECT_FALSE(is_answer(calibrate(make_world(lens, seed, frontal), with_model(model)).status))
          << where;
    }
    EXPECT_EQ(calibrate(tilted, with_model("f")).status, Status::ok);
  }
}

// 15 views near enough to show the distortion, with tilts below one degree.
Dataset nearly_frontal_world(int seed, double sigma_px, double max_tilt_deg) {
  WorldOptions options;
  options.num_views = 15;
  options.sigma_px = sigma_px;
  options.max_tilt_deg = max_tilt_deg;
  options.min_distance_m = 0.45;
  options.max_distance_m = 0.7;
  return make_world(Perspective({900, 900, 644, 396, 0.09, -0.22, 6e-4, -4e-4, 0.13}), seed,
                    options);
}

// Undistorted lenses of any focal length fit nearly frontal views alike, and the distortion that
// the start does not have yet chose one between 190 and 5,800 px; from there the solver may take
// more steps than it has.
TEST(Honesty, NearlyFrontalViewsStartAtAUsualFocalLength) {
  for (int seed = 1; seed <= 10; ++seed) {
    const Dataset dataset = nearly_frontal_world(seed, 0.02, 0.5);
    const internal::CalibrationInput input = internal::calibration_input(dataset, {});
    const auto start =
        internal::calibration_seed(Model::named("opencv5"), input.image_size, input.views, {});
    ASSERT_TRUE(start);
    EXPECT_GT(start->free_values[0], 600) << seed;
    EXPECT_LT(start->free_values[0], 1500) << seed;
    expect_within_claim(calibrate(dataset), std::to_string(seed));
  }
}

// A claim is made at a minimum: solvers that run out of iterations on the way along a valley go on.
TEST(Honesty, AFarStartWithFewIterationsGivesTheSameClaim) {
  for (int seed = 1; seed <= 3; ++seed) {
    const Dataset dataset = nearly_frontal_world(seed, 0.005, 1);
    const Calibration usual = calibrate(dataset, with_model("opencv5"));
    CalibrateOptions far = with_model("opencv5");
    far.start_focal_px = 180;
    far.max_iterations = 10;
    const Calibration c = calibrate(dataset, far);
    ASSERT_EQ(c.status, usual.status) << seed;
    ASSERT_TRUE(is_answer(c.status)) << seed;
    EXPECT_NEAR(parameters(c.camera->lens)[0], parameters(usual.camera->lens)[0],
                0.02 * usual.sigmas[0])
        << seed;
    EXPECT_NEAR(c.sigmas[0], usual.sigmas[0], 0.01 * usual.sigmas[0]) << seed;
  }
}

TEST(Honesty, OnePoseSeenTenTimesIsHardlyMore) {
  WorldOptions options;
  options.num_views = 1;
  options.min_tilt_deg = 30;
  for (int seed = 1; seed <= 3; ++seed) {
    Dataset world = make_world(pinhole(900, 900, 639.5, 399.5), seed, options);
    const Pose pose = world.truth->camera_from_world.at("0.png");
    Random random(7, static_cast<std::uint64_t>(seed));
    for (int i = 1; i < 10; ++i) {
      world.views.push_back(observe(world.truth->camera, pose, target_points(world.boards[0].board),
                                    options, random));
      world.views.back().image = std::to_string(i) + ".png";
    }
    for (const char* model : {"f", "f+c", "opencv5", "fisheye4"})
      expect_within_claim(calibrate(world, with_model(model)),
                          model + std::string(" ") + std::to_string(seed));
    EXPECT_EQ(calibrate(world, with_model("f")).status, Status::ok);
  }
}

// What is left of exact corners are digits. A bend is in the answer: it is a note, not a warning.
TEST(Honesty, ExactCornersAreNotWarnedOf) {
  WorldOptions options;
  options.num_views = 12;
  const auto warnings = [&](double bend_m, double sigma_px) {
    options.sigma_px = sigma_px;
    Dataset world = make_world(opencv5_lens(), 2, options);
    std::map<CornerId, Eigen::Vector3d> points = points_in_world(world.boards);
    Random random(9);
    for (View& view : world.views) {
      const Pose& pose = world.truth->camera_from_world.at(view.image);
      for (Observation& o : view.observations) {
        Eigen::Vector3d x = points.at(o.id);
        x.z() += bend_m * (1 - std::pow(x.x() / 0.33 - 1, 2));
        o.pixel = project(opencv5_lens(), pose * x).value() +
                  sigma_px * Eigen::Vector2d(random.normal(), random.normal());
      }
    }
    std::string all;
    for (const Finding& finding : calibrate(world, with_model("opencv5")).findings)
      if (finding.code != "extrapolated" && finding.code != "fold_in_image")
        all += finding.code + std::string(severity_name(finding.severity)) + "; ";
    return all;
  };
  EXPECT_EQ(warnings(0, 0.0001), "");
  EXPECT_EQ(warnings(1e-3, 0.03), "board_bentnote; ");
}

// Strong barrel distortion, nothing rejected: from the pinhole the solver runs into the fold.
TEST(Honesty, AFoldIsNoMinimum) {
  const Lens lens = Perspective({744, 744, 655, 398, -0.267, -0.0067});
  CalibrateOptions options = with_model("radial2");
  options.reject_outliers = false;
  WorldOptions near;
  near.min_distance_m = 0.6;
  near.max_distance_m = 1.2;
  for (int seed = 1; seed <= 5; ++seed) {
    const Calibration c = calibrate(make_world(lens, seed, near), options);
    ASSERT_EQ(c.status, Status::ok) << seed;
    EXPECT_NEAR(c.sigma_px, near.sigma_px, 0.02) << seed;
  }
}

}  // namespace
}  // namespace tagcal
