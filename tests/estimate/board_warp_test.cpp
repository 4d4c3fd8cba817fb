#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "spoiled_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
namespace {

// The usual world, seen of a board that is bent by bow_m.x along x and bow_m.y along y.
Dataset bent_world(const Lens& lens, std::uint64_t seed, const Eigen::Vector2d& bow_m,
                   const WorldOptions& options) {
  const Dataset world = make_world(lens, seed, options);
  const std::vector<TargetPoint> points = target_points(world.boards[0].board);
  Eigen::Vector3d low = points[0].position, high = low;
  for (const TargetPoint& p : points) {
    low = low.cwiseMin(p.position);
    high = high.cwiseMax(p.position);
  }
  const auto bend = [&](TargetPoint& p) {
    const double x = 2 * (p.position.x() - low.x()) / (high.x() - low.x()) - 1;
    const double y = 2 * (p.position.y() - low.y()) / (high.y() - low.y()) - 1;
    p.position.z() += bow_m.x() * (1 - x * x) + bow_m.y() * (1 - y * y);
  };
  return seen_otherwise(world, options, bend, seed);
}

const Lens kBentLens = Perspective({900, 900, 651, 392, -0.1});

bool tells_of_bend(const Calibration& c) {
  return std::ranges::count(c.findings, "board_bent", &Finding::code) > 0;
}

TEST(BoardWarp, IsFoundWithItsDeviation) {
  const Eigen::Vector2d bow_m(0.0005, -0.0003);
  WorldOptions options;
  options.num_views = 10;
  CalibrateOptions with_warp;
  with_warp.board_warp = true;
  double sum = 0;
  int right = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    const Calibration c = calibrate(bent_world(kBentLens, seed, bow_m, options), with_warp);
    ASSERT_EQ(c.status, Status::ok);
    right += c.model == "radial1";
    ASSERT_TRUE(c.board_warp.has_value());
    EXPECT_LT(c.board_warp->sigma_mm.maxCoeff(), 0.06);
    for (int i = 0; i < 2; ++i) {
      const double z = (c.board_warp->bend_mm[i] - 1e3 * bow_m[i]) / c.board_warp->sigma_mm[i];
      EXPECT_LT(std::abs(z), 4) << seed;
      sum += z * z;
    }
    EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 900), 4 * c.sigmas[0]);
  }
  EXPECT_LT(sum, 26);  // chi-square of 8: p = 0.001
  // BIC of 2,830 residuals takes a coefficient too many in one of 200.
  EXPECT_GE(right, 3);
}

// Without its bend, this board moves corners by several pixels: all would be outliers.
TEST(BoardWarp, IsSolvedTogetherWithLensAndPoses) {
  const Eigen::Vector2d bow_m(0.008, -0.004);
  WorldOptions options;
  options.num_views = 8;
  options.sigma_px = 0;
  const Dataset world = bent_world(kBentLens, 3, bow_m, options);
  CalibrateOptions with_warp;
  with_warp.board_warp = true;
  for (const std::string model : {"radial1", "opencv5", "auto"}) {
    with_warp.model = model;
    const Calibration c = calibrate(world, with_warp);
    ASSERT_EQ(c.status, Status::ok) << model;
    EXPECT_TRUE(c.outliers.empty()) << model;
    // `auto` weighs the priors by the noise of a larger lens, which is not zero to the last digit.
    const double bound = model == "auto" ? 2e-3 : 1e-6;
    EXPECT_LT((c.board_warp->bend_mm - 1e3 * bow_m).norm(), bound) << model;
    EXPECT_NEAR(parameters(c.camera->lens)[0], 900, bound) << model;
  }
}

// The option asks for one flat board; the shape is in the answer without it.
TEST(BoardWarp, IsInTheAnswerWithoutItsOption) {
  WorldOptions options;
  options.num_views = 6;
  const Dataset world = bent_world(kBentLens, 2, {5e-4, 0}, options);
  CalibrateOptions plain;
  plain.model = "radial1";
  CalibrateOptions asked = plain;
  asked.board_warp = true;
  const Calibration without = calibrate(world, plain), with = calibrate(world, asked);
  ASSERT_EQ(with.status, Status::ok);
  EXPECT_EQ(with.sigmas, without.sigmas);
  EXPECT_EQ(with.board_warp->bend_mm, without.board_warp->bend_mm);
}

TEST(BoardWarp, IsToldOf) {
  WorldOptions options;
  options.num_views = 10;
  CalibrateOptions plain;
  plain.model = "radial1";
  for (int seed = 1; seed <= 10; ++seed) {
    EXPECT_TRUE(
        tells_of_bend(calibrate(bent_world(kBentLens, seed, {5e-4, 5e-4}, options), plain)));
    EXPECT_FALSE(tells_of_bend(calibrate(bent_world(kBentLens, seed, {0, 0}, options), plain)));
  }
}

// Twisted, or printed longer along y: in the answer, within its deviations, and named.
TEST(BoardWarp, TwistAndPrintAspectAreFound) {
  WorldOptions options;
  options.num_views = 12;
  const double twist_m = 6e-4, aspect = 0.003;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto twisted = [&](TargetPoint& p) {
      p.position.z() += twist_m * (p.position.x() / 0.33 - 1) * (p.position.y() / 0.33 - 1);
      p.position.y() *= 1 + aspect;
    };
    const Calibration c = calibrate(seen_otherwise(
        make_world(kBentLens, static_cast<int>(seed), options), options, twisted, seed));
    ASSERT_EQ(c.status, Status::ok);
    ASSERT_TRUE(c.board_warp.has_value());
    const BoardWarp& board = *c.board_warp;
    const double of_twist = (board.twist_mm - 1e3 * twist_m) / board.sigma_twist_mm;
    const double of_aspect = (board.aspect - aspect) / board.sigma_aspect;
    EXPECT_LT(std::abs(of_twist), 4.5) << seed;
    EXPECT_LT(std::abs(of_aspect), 4.5) << seed;
    sum += of_twist * of_twist + of_aspect * of_aspect;
    EXPECT_TRUE(tells_of_bend(c)) << seed;
    EXPECT_TRUE(std::ranges::count(c.findings, "print_aspect", &Finding::code)) << seed;
    EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 900), 4 * c.sigmas[0]) << seed;
  }
  EXPECT_LT(sum, 33);  // chi-square of 12: p = 0.001
}

const Substrate kGlass = {Material::glass, Material::glass};

bool says(const Calibration& c, const std::string& code) {
  return std::ranges::count(c.findings, code, &Finding::code) > 0;
}

// The covariance comes from the residuals of the views: a narrower prior narrows the focal length's
// on average, not with every noise.
TEST(BoardWarp, AFlatBoardOfGlassIsKnownBetter) {
  CalibrateOptions radial;
  radial.model = "radial1";
  WorldOptions options;
  for (const int views : {2, 4, 10}) {
    options.num_views = views;
    double log_ratio = 0, sum = 0;
    for (int seed = 1; seed <= 5; ++seed) {
      const Dataset world = make_world(kBentLens, seed, options);
      const Calibration paper = calibrate(world, radial);
      const Calibration glass = calibrate(made_of(world, kGlass), radial);
      ASSERT_TRUE(is_answer(paper.status) && is_answer(glass.status));
      const BoardWarp &loose = *paper.board_warp, &tight = *glass.board_warp;
      EXPECT_LT(tight.sigma_mm.x(), 0.9 * loose.sigma_mm.x()) << views << " " << seed;
      EXPECT_LT(tight.sigma_mm.y(), 0.9 * loose.sigma_mm.y()) << views << " " << seed;
      EXPECT_LT(tight.sigma_aspect, loose.sigma_aspect) << views << " " << seed;
      EXPECT_LT(glass.sigmas[0], 1.1 * paper.sigmas[0]) << views << " " << seed;
      log_ratio += std::log(glass.sigmas[0] / paper.sigmas[0]);
      const double z = (parameters(glass.camera->lens)[0] - 900) / glass.sigmas[0];
      sum += z * z;
      EXPECT_FALSE(says(glass, "flatness_exceeded") || says(glass, "print_exceeded"));
    }
    EXPECT_LT(log_ratio, 0) << views;
    EXPECT_LT(sum, 20.5) << views;  // chi-square of 5: p = 0.001
  }
}

// A millimetre is usual for paper, and 21 standard deviations of glass: named, and in
// the answer.
TEST(BoardWarp, ABentBoardContradictsGlass) {
  WorldOptions options;
  for (const int views : {3, 4, 6, 10, 20})
    for (int seed = 1; seed <= 4; ++seed) {
      options.num_views = views;
      const Dataset world = bent_world(kBentLens, seed, {1e-3, 0}, options);
      const Calibration paper = calibrate(world), glass = calibrate(made_of(world, kGlass));
      EXPECT_TRUE(tells_of_bend(paper) && !says(paper, "flatness_exceeded"))
          << views << " " << seed;
      EXPECT_TRUE(!tells_of_bend(glass) && says(glass, "flatness_exceeded"))
          << views << " " << seed;
      EXPECT_LT(std::abs(parameters(glass.camera->lens)[0] - 900), 4 * glass.sigmas[0])
          << views << " " << seed;
      const BoardWarp& board = *glass.board_warp;
      EXPECT_LT(std::abs(board.bend_mm.x() - 1), 5 * board.sigma_mm.x()) << views << " " << seed;
      for (const Finding& finding : glass.findings)
        if (finding.code == "flatness_exceeded") {
          EXPECT_EQ(finding.severity, Severity::warning);
          EXPECT_NE(finding.sentence.find("more than a board of glass has (sd 0.047 mm)"),
                    std::string::npos)
              << finding.sentence;
        }
    }
}

TEST(BoardWarp, AMisprintContradictsPaper) {
  WorldOptions options;
  options.num_views = 10;
  const double aspect = 0.02;
  for (int seed = 1; seed <= 4; ++seed) {
    const Dataset world = seen_otherwise(
        make_world(kBentLens, seed, options), options,
        [&](TargetPoint& p) { p.position.y() *= 1 + aspect; }, seed);
    const Calibration c = calibrate(world);
    EXPECT_TRUE(says(c, "print_exceeded") && !says(c, "print_aspect")) << seed;
    EXPECT_LT(std::abs(c.board_warp->aspect - aspect), 4 * c.board_warp->sigma_aspect) << seed;
    EXPECT_LT(std::abs(parameters(c.camera->lens)[0] - 900), 4 * c.sigmas[0]) << seed;
  }
}

TEST(BoardWarp, ASubstrateHasARange) {
  const Dataset world = make_world(kBentLens, 1);
  for (const double share : {0.0, -0.001, 0.2, std::nan("")}) {
    EXPECT_THROW(calibrate(made_of(world, {share, Material::paper})), Error) << share;
    EXPECT_THROW(calibrate(made_of(world, {Material::paper, share})), Error) << share;
  }
}

TEST(BoardWarp, NeedsOneFlatBoard) {
  Dataset world = make_world(kBentLens, 1);
  CalibrateOptions options;
  options.board_warp = true;
  world.boards.push_back({make_board(AprilGrid{2, 2, 0.05, 0.3, 100}), Pose()});
  EXPECT_THROW(calibrate(world, options), Error);
}

}  // namespace
}  // namespace tagcal
