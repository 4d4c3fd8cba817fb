#include "tagcal/estimate/calibrate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "calibrations.hpp"
#include "tagcal/error.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

// So near that the board spans the angles at which a fisheye and a perspective differ.
WorldOptions near() {
  WorldOptions options;
  options.min_distance_m = 0.35;
  options.max_distance_m = 0.8;
  return options;
}

// Every free parameter within `bound` of its standard deviations.
void expect_truth(const Calibration& c, const Lens& truth, double bound, const std::string& where) {
  ASSERT_EQ(c.status, Status::ok) << where;
  const auto exact = parameters(truth), estimate = parameters(c.camera->lens);
  ASSERT_EQ(exact.size(), estimate.size()) << where;
  for (std::size_t i = 0; i < exact.size(); ++i)
    EXPECT_LE(std::abs(estimate[i] - exact[i]), bound * c.sigmas[i] + 1e-12)
        << where << " " << parameter_names(truth)[i];
}

TEST(Calibrate, IsExactWithoutNoise) {
  WorldOptions options;
  options.sigma_px = 0;
  for (const auto& [model, lens] :
       {std::pair("opencv5", opencv5_lens()), std::pair("fisheye4", fisheye_lens()),
        std::pair("f", Lens(pinhole(900, 900, 639.5, 399.5)))}) {
    const Calibration c = calibrate(make_world(lens, 1, options), with_model(model, 0.1));
    ASSERT_TRUE(c.camera.has_value()) << model;
    EXPECT_EQ(c.status, Status::ok) << model;
    // The priors draw the estimate towards usual lenses, by far less than it claims.
    EXPECT_LT(c.rms_px, 1e-8) << model;
    for (std::size_t i = 0; i < parameters(lens).size(); ++i)
      EXPECT_NEAR(parameters(c.camera->lens)[i], parameters(lens)[i], 1e-4 * c.sigmas[i] + 1e-9)
          << model << i;
  }
}

TEST(Calibrate, ChoosesTheLensThatMadeTheData) {
  EXPECT_EQ(calibrate(make_world(opencv5_lens(), 2)).model, "opencv4");
  EXPECT_EQ(calibrate(make_world(fisheye_lens(), 2, near())).model, "fisheye4");
  // What both lenses fit alike is an ordinary lens, and no more than it takes.
  for (int seed = 1; seed <= 5; ++seed)
    EXPECT_EQ(calibrate(make_world(pinhole(900, 900, 639.5, 399.5), seed)).model, "f");
}

TEST(Calibrate, FindsTheTruthAndItsNoise) {
  for (int seed = 1; seed <= 5; ++seed) {
    const Calibration c = calibrate(make_world(opencv5_lens(), seed), with_model("opencv5"));
    expect_truth(c, opencv5_lens(), 4, "seed " + std::to_string(seed));
    EXPECT_NEAR(c.sigma_px, 0.2, 0.01);
    EXPECT_TRUE(c.sigma_from_residuals);
    EXPECT_EQ(c.views.size(), 20u);
  }
}

TEST(Calibrate, ThirtyPercentWrongCornersDoNotMoveTheAnswer) {
  WorldOptions options = near();
  options.outlier_share = 0.3;
  for (const auto& [model, lens] :
       {std::pair("opencv4", opencv5_lens()), std::pair("fisheye4", fisheye_lens())}) {
    for (int seed = 1; seed <= 3; ++seed) {
      const Calibration c = calibrate(make_world(lens, seed, options));
      EXPECT_EQ(c.model, model);
      expect_truth(c, lens, 4, std::string(model) + " seed " + std::to_string(seed));
      EXPECT_NEAR(static_cast<double>(c.outliers.size()),
                  0.3 * (static_cast<double>(c.outliers.size()) + c.num_corners),
                  0.05 * c.num_corners);
    }
  }
}

TEST(Calibrate, StandardDeviationsAreThoseOfTheErrors) {
  const Model& model = Model::named("radial1");
  const Lens lens = Perspective({900, 900, 651, 392, -0.15});
  constexpr int kSeeds = 150;
  WorldOptions options;
  options.num_views = 6;
  double sum = 0;
  double pose_sum = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Dataset world = make_world(lens, 100 + seed, options);
    const Calibration c = calibrate(world, with_model("radial1", 0.2));
    ASSERT_EQ(c.status, Status::ok);
    sum += normalised_squared_error(model, c.camera->lens, lens, c.covariance);
    const CalibratedView& view = c.views.front();
    const Vector6d error =
        minus(view.camera_from_world, world.truth->camera_from_world.at(view.image));
    pose_sum += error.dot(Eigen::MatrixXd(view.covariance).ldlt().solve(error));
  }
  // A mean of 150 x 4 (and 150 x 6) squared normal deviates: sd 0.058 (0.047).
  EXPECT_NEAR(sum / (kSeeds * 4), 1, 0.18);
  EXPECT_NEAR(pose_sum / (kSeeds * 6), 1, 0.15);
}

TEST(Calibrate, CornersCovariancesAreUsed) {
  Dataset world = make_world(opencv5_lens(), 7);
  Random random(7);
  for (View& view : world.views) {
    for (Observation& o : view.observations) {
      // Half of the corners are ten times worse, and say so.
      const double sigma = random.uniform() < 0.5 ? 0.2 : 2.0;
      if (sigma > 1) o.pixel += 2.0 * Eigen::Vector2d(random.normal(), random.normal());
      o.covariance_px2 = Matrix2(sigma * sigma * Eigen::Matrix2d::Identity());
    }
  }
  const Calibration c = calibrate(world, with_model("opencv5"));
  expect_truth(c, opencv5_lens(), 4, "with covariances");
  for (View& view : world.views)
    for (Observation& o : view.observations) o.covariance_px2.reset();
  EXPECT_LT(1.1 * c.sigmas[0], calibrate(world, with_model("opencv5")).sigmas[0]);
}

TEST(Calibrate, AStatedNoiseStandsForTheCornersOwn) {
  Dataset world = make_world(pinhole(900, 900, 639.5, 399.5), 4);
  const Calibration plain = calibrate(world, with_model("f", 0.2));
  for (View& view : world.views)
    for (std::size_t i = 0; i < view.observations.size(); ++i)
      view.observations[i].covariance_px2 =
          Matrix2((i % 2 == 0 ? 9.0 : 0.01) * Matrix2::Identity());
  const Calibration stated = calibrate(world, with_model("f", 0.2));
  EXPECT_EQ(stated.sigmas, plain.sigmas);
  EXPECT_TRUE(calibrate(world, with_model("f")).sigma_of_corners);
}

TEST(Calibrate, AnUncertaintyNeedsADistance) {
  CalibrateOptions options;
  for (const double distance : {0.0, -1.0, std::nan("")}) {
    options.distances_m = {distance};
    EXPECT_THROW(calibrate(make_world(pinhole(900, 900, 639.5, 399.5), 1), options), Error);
  }
}

TEST(Calibrate, FurtherDistancesChangeNoClaim) {
  WorldOptions from_afar;  // so that the borders of the image have no corners
  from_afar.min_distance_m = 2;
  from_afar.max_distance_m = 2.5;
  const Dataset world = make_world(opencv5_lens(), 1, from_afar);
  const Calibration plain = calibrate(world);
  ASSERT_TRUE(has(plain, "extrapolated"));
  CalibrateOptions options;
  options.distances_m = {0.2, std::numeric_limits<double>::infinity(), 30};
  const Calibration further = calibrate(world, options);
  ASSERT_EQ(further.projection.size(), 4u);
  EXPECT_EQ(further.projection[1].distance_m, plain.projection[1].distance_m);
  EXPECT_EQ(further.projection[3].distance_m, 30);
  EXPECT_EQ(camera_error_px(further), camera_error_px(plain));
  ASSERT_EQ(further.findings.size(), plain.findings.size());
  for (std::size_t i = 0; i < plain.findings.size(); ++i)
    EXPECT_EQ(further.findings[i].sentence, plain.findings[i].sentence);
}

TEST(Calibrate, FrontalBoardsHoldNoFocalLength) {
  WorldOptions options;
  options.max_tilt_deg = 0;
  options.num_views = 5;
  for (int seed = 1; seed <= 3; ++seed) {
    const Dataset world = make_world(pinhole(900, 900, 639.5, 399.5), seed, options);
    for (const char* model : {"f", "f+c", "opencv5"})
      EXPECT_EQ(calibrate(world, with_model(model)).status, Status::focal_not_observable)
          << model << " seed " << seed;
    const Calibration c = calibrate(world);
    EXPECT_EQ(c.status, Status::focal_not_observable);
    EXPECT_EQ(c.model, "weak");
  }
}

TEST(Calibrate, OneViewRepeatedCountsOnce) {
  Dataset world = make_world(pinhole(900, 900, 639.5, 399.5), 3);
  world.views.resize(1);
  for (int i = 1; i < 10; ++i) {
    world.views.push_back(world.views[0]);
    world.views.back().image = "copy.png";
  }
  const Calibration c = calibrate(world, with_model("pinhole"));
  EXPECT_FALSE(is_answer(c.status));
  EXPECT_GE(c.findings.size(), 9u);
}

TEST(Calibrate, NoiseHasNoConsensus) {
  WorldOptions options;
  options.outlier_share = 1;
  for (int seed = 1; seed <= 5; ++seed)
    EXPECT_FALSE(is_answer(calibrate(make_world(opencv5_lens(), seed, options)).status)) << seed;
}

TEST(Calibrate, TooFewCornersAreDegenerate) {
  Dataset world = make_world(opencv5_lens(), 4);
  world.views.resize(3);
  for (View& view : world.views) view.observations.resize(4);
  EXPECT_EQ(calibrate(world, with_model("f")).status, Status::degenerate);
  for (View& view : world.views) view.observations.resize(2);
  EXPECT_EQ(calibrate(world).status, Status::degenerate);
}

TEST(Calibrate, PointsInSpace) {
  Random random(11);
  Dataset world;
  world.image_size = {1280, 800};
  Points board;
  for (int i = 0; i < 60; ++i)
    board.points.push_back(
        {{i, 0},
         {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.2, 0.2)}});
  world.boards = {{make_board(board), Pose()}};
  const Lens lens = Perspective({900, 900, 651, 392, -0.1});
  WorldOptions options;
  options.outlier_share = 0.2;
  for (int i = 0; i < 8; ++i) {
    const Pose pose = looking_at_board(Eigen::Vector3d::Zero(), random.uniform(0, 1), 1.2, random);
    world.views.push_back(observe({lens, world.image_size}, pose, board.points, options, random));
    world.views.back().image = std::to_string(i);
  }
  expect_truth(calibrate(world, with_model("radial1")), lens, 4, "points in space");
}

TEST(Calibrate, TwoBoardsInOneScene) {
  Dataset world;
  world.image_size = {1280, 800};
  world.boards = {
      {make_board(AprilGrid{4, 4, 0.08, 0.3, 0}), Pose(exp_rotation({0, -0.7, 0}), {-0.45, 0, 0})},
      {make_board(AprilGrid{4, 4, 0.08, 0.3, 16}), Pose(exp_rotation({0, 0.7, 0}), {0, 0, 0.1})}};
  std::vector<TargetPoint> points;
  for (const auto& [id, position] : points_in_world(world.boards)) points.push_back({id, position});
  Random random(12);
  const Lens lens = opencv5_lens();
  for (int i = 0; i < 12; ++i) {
    const Pose pose = looking_at_board({0, 0.2, 0}, random.uniform(0, 0.7), 1.1, random);
    world.views.push_back(observe({lens, world.image_size}, pose, points, {}, random));
    world.views.back().image = std::to_string(i);
  }
  expect_truth(calibrate(world, with_model("opencv5")), lens, 4, "two boards");
}

TEST(Calibrate, UnknownModelIsAnError) {
  EXPECT_THROW(calibrate(make_world(opencv5_lens(), 1), with_model("opencv55")), Error);
}

void expect_equal(const Calibration& a, const Calibration& b) {
  EXPECT_EQ(a.covariance, b.covariance);
  for (std::size_t i = 0; i < a.sigmas.size(); ++i)
    EXPECT_EQ(parameters(a.camera->lens)[i], parameters(b.camera->lens)[i]);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t i = 0; i < a.views.size(); ++i)
    EXPECT_EQ(minus(a.views[i].camera_from_world, b.views[i].camera_from_world), Vector6d::Zero());
}

TEST(Calibrate, EqualInputGivesEqualOutput) {
  const Dataset world = make_world(opencv5_lens(), 9);
  expect_equal(calibrate(world), calibrate(world));
}

TEST(Calibrate, TheNumberOfThreadsDoesNotMatter) {
  WorldOptions many;
  many.num_views = 160;
  const Dataset world = make_world(opencv5_lens(), 10, many);
  CalibrateOptions options = with_model("opencv5");
  const Calibration one = calibrate(world, options);
  for (const std::size_t threads : {0, 2, 3}) {
    options.num_threads = threads;
    expect_equal(one, calibrate(world, options));
  }
}

// Points in the room, with left-handed coordinates in the file.
TEST(Calibrate, PointsThatFitInTheirMirrorImageOnlyAreSaid) {
  Random random(4);
  Points points;
  for (int id = 0; id < 60; ++id)
    points.points.push_back(
        {{id, 0},
         {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.15, 0.15)}});
  WorldOptions options;
  Dataset world;
  world.image_size = {1280, 800};
  world.boards = {{{points, {}}, Pose()}};
  for (int i = 0; i < 8; ++i)
    world.views.push_back(
        observe({opencv5_lens(), world.image_size},
                looking_at_board(Eigen::Vector3d::Zero(), random.uniform(0, 0.8), 1.2, random),
                points.points, options, random));
  EXPECT_EQ(calibrate(world).status, Status::ok);
  for (TargetPoint& point : std::get<Points>(world.boards[0].board.pattern).points)
    point.position.z() *= -1;
  const Calibration c = calibrate(world);
  EXPECT_EQ(c.status, Status::no_consensus);
  EXPECT_TRUE(std::ranges::any_of(c.findings, [](const Finding& finding) {
    return finding.sentence.find("only in their mirror image") != std::string::npos;
  }));
}

}  // namespace
}  // namespace tagcal
