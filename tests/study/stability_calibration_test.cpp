#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "study/atlas/map_calibration.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
using namespace study;
namespace {

CalibrationTask eight_views(double largest_tilt_deg) {
  Random random(7);
  CalibrationTask task = pinhole_task();
  for (int i = 0; i < 8; ++i)
    add_view(task, draw_view(random.uniform(0, largest_tilt_deg), random), random);
  return task;
}

// An answer of pinhole whose fx is so many of its standard deviations off.
LensAnswer off_by(double sigmas, double sigma_px = 2) {
  LensAnswer answer;
  answer.success = true;
  answer.claim = {
      &Model::named("pinhole"),
      {pinhole(900 + sigmas * sigma_px, 900, 651, 392), pinhole_task().dataset.image_size},
      sigma_px * sigma_px * Eigen::MatrixXd::Identity(4, 4)};
  return answer;
}

TEST(CalibrationJudge, TheCameraMatrixIsHeldToItsClaim) {
  const CalibrationJudge judge(ask_all(eight_views(45)));
  EXPECT_EQ(judge.judge(off_by(4)).outcome, StabilityOutcome::right_and_said);
  EXPECT_EQ(judge.judge(off_by(8)).outcome, StabilityOutcome::wrong_and_silent);
  LensAnswer doubted = off_by(8);
  doubted.doubted = true;
  EXPECT_EQ(judge.judge(doubted).outcome, StabilityOutcome::wrong_and_said);
  LensAnswer no_claim = off_by(400);
  no_claim.claim.covariance.resize(0, 0);
  EXPECT_EQ(judge.judge(no_claim).outcome, StabilityOutcome::wrong_and_silent);
  no_claim.claim.camera.lens = pinhole(900, 900, 651, 392);
  EXPECT_EQ(judge.judge(no_claim).outcome, StabilityOutcome::right_and_said);
}

TEST(CalibrationJudge, AnotherLensWithoutAClaimIsHeldToTheBoundOfTheProjection) {
  const CalibrationJudge judge(ask_all(eight_views(45), JudgedLens::projection));
  LensAnswer other = off_by(0);
  other.claim.covariance.resize(0, 0);
  other.claim.model = &Model::named("fisheye4");
  // tan(a) = a + a^3 / 3 + 2 a^5 / 15 + 17 a^7 / 315 + 62 a^9 / 2835
  other.claim.camera.lens =
      Fisheye({900, 900, 651, 392, 1.0 / 3, 2.0 / 15, 17.0 / 315, 62.0 / 2835});
  EXPECT_EQ(judge.judge(other).outcome, StabilityOutcome::right_and_said);
  other.claim.camera.lens = Fisheye({900, 900, 651, 392, 0, 0, 0, 0});
  EXPECT_EQ(judge.judge(other).outcome, StabilityOutcome::wrong_and_silent);
}

TEST(CalibrationJudge, RefusedWhatCouldBeKnownAndWhatNot) {
  const CalibrationJudge good(ask_all(eight_views(45))), frontal(ask_all(eight_views(0)));
  EXPECT_TRUE(good.knowable());
  EXPECT_FALSE(frontal.knowable());
  EXPECT_FALSE(CalibrationJudge(ask_all(eight_views(2))).knowable());  // held, but weakly
  EXPECT_EQ(good.judge({}).outcome, StabilityOutcome::right_but_refused);
  EXPECT_EQ(good.judge({}, true).outcome, StabilityOutcome::wrong_and_said);
  EXPECT_EQ(frontal.judge({}).outcome, StabilityOutcome::wrong_and_said);
}

TEST(CalibrationJudge, ProjectionsAreHeldToTheirClaimInsideAndAtTheCorners) {
  for (const JudgedLens judged : {JudgedLens::projection, JudgedLens::image_corners}) {
    const CalibrationJudge judge(ask_all(eight_views(45), judged));
    EXPECT_EQ(judge.judge(off_by(3)).outcome, StabilityOutcome::right_and_said);
    EXPECT_EQ(judge.judge(off_by(40)).outcome, StabilityOutcome::wrong_and_silent);
  }
}

TEST(CalibrationJudge, ErrorsAreMultiplesOfTheBound) {
  const CalibrationJudge judge(ask_all(eight_views(45)));
  const double one = judge.judge(off_by(1)).over_bound, two = judge.judge(off_by(2)).over_bound;
  EXPECT_GT(one, 0);
  EXPECT_NEAR(two / one, 2, 0.02);
}

TEST(StabilityMark, OfCalibrationsIsOverTheMap) {
  StabilityMap map;
  map.axes = {{"views", "", {1, 2}, {}}};
  map.methods = {{"tagcal calibrate", "", true}, {"peer", ""}};
  StabilityResult result;
  for (std::size_t cell = 0; cell < 2; ++cell)
    for (std::size_t method = 0; method < 2; ++method) {
      StabilityTally& t = result.tallies.emplace_back();
      t.cell = cell, t.method = method, t.trials = 600, t.count = {600, 0, 0, 0};
    }
  result.tallies[2].count = {599, 0, 1, 0};  // ours, in the second cell
  result.tallies[2].first_silent = 17;
  result.tallies[3].count = {0, 0, 600, 0};  // the peer
  EXPECT_EQ(missing_marks(map, result).size(), 1u);
  map.mark_over_map = true;
  EXPECT_TRUE(missing_marks(map, result).empty());  // 1 of 1,200
  result.tallies[2].count = {598, 0, 2, 0};
  const auto missing = missing_marks(map, result);
  ASSERT_EQ(missing.size(), 1u);
  EXPECT_EQ(missing[0].trials, 1200);
  EXPECT_EQ(missing[0].cell, 1u);
  EXPECT_EQ(missing[0].first_silent, 17);
}

TEST(CalibrationMaps, OursAnswersWhatIsPlainAndRefusesWhatIsNot) {
  for (const StabilityMap& map : calibration_maps()) {
    if (map.name != "calibrate-views-tilt") continue;
    StabilityMap two = map;
    two.axes[0].values = {8};
    two.axes[1].values = {0, 40};
    two.methods.resize(2);
    StabilityOptions options;
    options.trials = 2;
    const StabilityResult result = run_map(two, options);
    for (const StabilityTally& t : result.tallies)
      EXPECT_EQ(
          t.of(t.cell == 0 ? StabilityOutcome::wrong_and_said : StabilityOutcome::right_and_said),
          2)
          << t.cell << ' ' << t.method;
  }
}

// How often one of our methods is wrong and silent in one cell of a map.
int silent(const std::string& name, const std::vector<double>& at, std::size_t method, int trials) {
  for (StabilityMap& map : calibration_maps()) {
    if (map.name != name) continue;
    for (std::size_t a = 0; a < at.size(); ++a) {
      map.axes[a].values = {at[a]};
      map.axes[a].names.clear();
    }
    map.methods = {map.methods[method]};
    const auto draw = map.draw;
    map.draw = [draw, method](std::span<const double> values, Random& random) -> StabilityProblem {
      return [problem = draw(values, random), method](std::size_t) { return problem(method); };
    };
    StabilityOptions options;
    options.trials = trials;
    return run_map(map, options).tallies[0].of(StabilityOutcome::wrong_and_silent);
  }
  ADD_FAILURE() << name;
  return -1;
}

// The centre of the image is taken for the principal point, which two views hardly hold.
TEST(OursIsNotSilent, WhereTheCentreIsAssumed) {
  EXPECT_EQ(silent("calibrate-views-tilt", {2, 20}, 0, 25), 0);
}

// Focal length and principal point of planes that are nearly parallel trade along a curve.
TEST(OursIsNotSilent, WhereAWeakDirectionBends) {
  EXPECT_EQ(silent("calibrate-parallel", {8, 1}, 1, 40), 0);
}

// A coefficient that the corners do not show is extrapolated to the corners of the image.
TEST(OursIsNotSilent, WhereACoefficientIsLeftOut) {
  EXPECT_EQ(silent("calibrate-extrapolation", {-0.1, 1}, 0, 15), 0);
}

// The fisheye rejects what it cannot bend to.
TEST(OursIsNotSilent, AskedForAFisheyeOfAnOrdinaryLens) {
  EXPECT_EQ(silent("calibrate-wrong-lens", {0, 400}, 2, 25), 0);
}

// Fitted with them, a wide fisheye explains corners to which it was bent badly without them.
TEST(CalibrationMaps, NoRightCornerIsLost) {
  for (int i = 0; i < 40; ++i) {
    Random random(7, static_cast<std::uint64_t>(i));
    CalibrationTask task =
        empty_task(Fisheye({400, 400, 633, 405, 0.02, -0.01, 0.003, -0.0005}), "fisheye4", 0.3);
    for (int v = 0; v < 10; ++v)
      add_view(task, draw_view(random.uniform(0, 45), random, 400.0 / 1100), random);
    CalibrateOptions options;
    options.model = "fisheye4";
    options.sigma_px = 0.3;
    const Calibration c = calibrate(task.dataset, options);
    EXPECT_TRUE(c.outliers.empty()) << i;
    for (const Finding& finding : c.findings)
      EXPECT_TRUE(finding.code != "other_lens" && finding.code != "model_too_small")
          << i << finding.sentence;
  }
}

// What comes of the trial in which both kinds of lens explain all views but one, and the fisheye
// that one, too.
StabilityOutcome of_one_fisheye_view(std::size_t method) {
  for (const StabilityMap& map : calibration_maps()) {
    if (map.name != "calibrate-wrong-lens") continue;
    Random random(1, (std::uint64_t{5} << 32) + 92);
    const auto attempt = map.draw(map.values(5), random)(method);
    attempt.solve();
    return attempt.answer().outcome;
  }
  return StabilityOutcome::wrong_and_silent;
}

TEST(OursIsNotSilent, WhereOneViewShowsTheFisheye) {
  EXPECT_EQ(of_one_fisheye_view(0), StabilityOutcome::right_and_said);  // auto
  // opencv5 by its name: what it claims covers the fisheye, or it says that this explains more.
  EXPECT_NE(of_one_fisheye_view(1), StabilityOutcome::wrong_and_silent);
}

// Every map draws problems in all of its cells that its judge can hold to the truth.
TEST(CalibrationMaps, EveryCellCanBeDrawn) {
  for (const StabilityMap& map : calibration_maps()) {
    EXPECT_TRUE(map.mark_over_map);
    for (std::size_t cell = 0; cell < map.num_cells(); ++cell) {
      Random random(1, static_cast<std::uint64_t>(cell) << 32);
      EXPECT_NO_THROW(map.draw(map.values(cell), random)) << map.name << ' ' << cell;
    }
  }
}

}  // namespace
}  // namespace tagcal
