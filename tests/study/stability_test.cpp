#include "study/atlas/stability.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "expect.hpp"
#include "study/atlas/atlas_page.hpp"
#include "study/atlas/stability_file.hpp"
#include "study/atlas/stability_judge.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal {
using namespace study;
namespace {

StabilityMap map_named(const std::string& name) {
  for (StabilityMap& map : stability_maps())
    if (map.name == name) return map;
  ADD_FAILURE() << name;
  return {};
}

// A map whose outcomes are those of a table: the method by its number, one outcome a trial.
StabilityMap scripted_map() {
  StabilityMap map;
  map.name = "scripted";
  map.title = "Scripted";
  map.axes = {{"tilt", "deg", {0, 10}, {}}, {"kind", "", {0, 1, 2}, {"one", "two, so", "three"}}};
  map.methods = {{"tagcal estimate_ours", "as it is", true, true}, {"peer", "as it is"}};
  map.trials = 8;
  map.peer_trials = 4;
  map.quick_trials = 2;
  map.draw = [](std::span<const double> at, Random& random) -> StabilityProblem {
    const double error = at[0] + at[1] + random.uniform();
    return [error](std::size_t method) -> Prepared<StabilityVerdict> {
      return {[] {},
              [error, method] {
                StabilityVerdict verdict;
                verdict.outcome =
                    static_cast<StabilityOutcome>((method + std::size_t(error * 7)) % kNumOutcomes);
                if (verdict.outcome != StabilityOutcome::right_but_refused)
                  verdict.over_bound = error;
                verdict.said = method == 0 ? "ok" : "answer";
                return verdict;
              }};
    };
  };
  return map;
}

void expect_same(const StabilityResult& a, const StabilityResult& b) {
  ASSERT_EQ(a.tallies.size(), b.tallies.size());
  for (std::size_t i = 0; i < a.tallies.size(); ++i) {
    const StabilityTally &s = a.tallies[i], &t = b.tallies[i];
    EXPECT_EQ(s.count, t.count);
    EXPECT_EQ(s.said, t.said);
    EXPECT_EQ(s.first_silent, t.first_silent);
    EXPECT_TRUE(s.rms_over_bound == t.rms_over_bound ||
                (std::isnan(s.rms_over_bound) && std::isnan(t.rms_over_bound)));
    EXPECT_TRUE(s.median_over_bound == t.median_over_bound ||
                (std::isnan(s.median_over_bound) && std::isnan(t.median_over_bound)));
  }
}

TEST(FiveSigma, IsTheChiSquareOfTheSameRarity) {
  EXPECT_NEAR(five_sigma_square(1), 25, 1e-9);
  // Q(6 dof, x) = e^(-x/2) (1 + x/2 + (x/2)^2 / 2).
  const double x = five_sigma_square(6);
  EXPECT_NEAR(std::exp(-x / 2) * (1 + x / 2 + x * x / 8) / std::erfc(5 / std::sqrt(2.0)), 1, 1e-9);
  EXPECT_GT(five_sigma_square(7), x);
}

TEST(Stability, EveryMapIsWhole) {
  std::set<std::string> names;
  for (const StabilityMap& map : stability_maps()) {
    SCOPED_TRACE(map.name);
    EXPECT_TRUE(names.insert(map.name).second);
    EXPECT_TRUE(map.axes.size() == 1 || map.axes.size() == 2);
    for (const StabilityAxis& axis : map.axes)
      EXPECT_TRUE(axis.names.empty() || axis.names.size() == axis.values.size());
    EXPECT_EQ(map.trials, map.mark_over_map ? 300 : 3000);
    EXPECT_TRUE(map.methods.front().ours);
    EXPECT_GE(std::count_if(map.methods.begin(), map.methods.end(),
                            [](const StabilityMethod& m) { return !m.ours && m.drawn; }),
              1);
    for (const std::string& text : {map.title, map.what, map.why, map.answer})
      EXPECT_FALSE(text.empty());
  }
}

TEST(Stability, CellsRunThroughTheLastAxisFirst) {
  const StabilityMap map = scripted_map();
  EXPECT_EQ(map.num_cells(), 6u);
  EXPECT_EQ(map.values(4), (std::vector<double>{10, 1}));
  EXPECT_EQ(map.cell_label(4), "tilt 10 deg, two, so");
}

TEST(Stability, CountsWhatTheVerdictsAre) {
  const StabilityResult result = run_map(scripted_map(), {});
  ASSERT_EQ(result.tallies.size(), 12u);
  for (const StabilityTally& t : result.tallies) {
    EXPECT_EQ(t.trials, t.method == 0 ? 8 : 4);
    int sum = 0;
    for (const int n : t.count) sum += n;
    EXPECT_EQ(sum, t.trials);
    EXPECT_EQ(t.said.at(t.method == 0 ? "ok" : "answer"), t.trials);
    EXPECT_EQ(t.first_silent >= 0, t.of(StabilityOutcome::wrong_and_silent) > 0);
    EXPECT_EQ(t.first_refused >= 0, t.of(StabilityOutcome::right_but_refused) > 0);
    EXPECT_EQ(std::isfinite(t.rms_over_bound), t.of(StabilityOutcome::right_and_said) > 0);
  }
}

TEST(Stability, TheMarkIsOneInAThousandAndTwoInAHundred) {
  StabilityTally tally;
  tally.trials = 3000;
  tally.count = {2938, 1, 2, 59};
  EXPECT_FALSE(misses_mark(tally));
  tally.count = {2937, 1, 3, 59};
  EXPECT_TRUE(misses_mark(tally));
  tally.count = {2937, 1, 2, 60};
  EXPECT_TRUE(misses_mark(tally));
}

TEST(Stability, SameOutcomesWhateverTheThreads) {
  StabilityMap map = map_named("swapped");
  map.axes = {{"mix-up", "", {0, 3}, {"a", "b"}}, {"board", "", {2}, {"2 x 2"}}};
  StabilityOptions options;
  options.trials = 12;
  const StabilityResult one = run_map(map, options);
  options.threads = 3;
  expect_same(one, run_map(map, options));
  options.seed = 2;
  EXPECT_NE(one.tallies[0].median_over_bound, run_map(map, options).tallies[0].median_over_bound);
}

TEST(Stability, BadOptionsAreErrors) {
  StabilityOptions options;
  options.trials = -1;
  EXPECT_THROW(run_map(scripted_map(), options), Error);
  options.trials = 1;
  options.threads = -1;
  EXPECT_THROW(run_map(scripted_map(), options), Error);
}

// A tag that is seen well, and answers of every kind to it.
class Judged : public testing::Test {
 protected:
  static PoseQuestion question() {
    Random random(3);
    PoseQuestion q;
    ViewRange range{30, 30, 0.5, 0.5, 0.5};
    q.task = draw_task(square_points(0.088), range, random);
    q.right = {0, 1, 2, 3};
    q.plane = true;
    return q;
  }

  // Off by so many standard deviations about the camera's x axis, with or without a claim.
  static PoseAnswer off_by(double sigmas, bool claims) {
    const PoseTask task = question().task;
    const Matrix6 covariance = pose_information(task).inverse();
    PoseAnswer answer;
    answer.success = true;
    Vector6d step = Vector6d::Zero();
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> root{Eigen::Matrix<double, 6, 6>(covariance)};
    step = root.matrixL() * Vector6d(sigmas * Vector6d::Unit(0));
    answer.camera_from_target = retract(task.camera_from_target, step);
    if (claims) answer.covariance = covariance, answer.status = Status::ok;
    return answer;
  }

  static StabilityOutcome outcome(const PoseAnswer& answer, const PoseQuestion& q = question()) {
    return PoseJudge(q).judge(answer).outcome;
  }
};

TEST_F(Judged, RightWithinFiveSigmaOfTheClaimOrOfTheBound) {
  const double edge = std::sqrt(five_sigma_square(6));
  for (const bool claims : {true, false}) {
    EXPECT_EQ(outcome(off_by(0.98 * edge, claims)), StabilityOutcome::right_and_said);
    EXPECT_EQ(outcome(off_by(1.02 * edge, claims)), StabilityOutcome::wrong_and_silent);
  }
  EXPECT_NEAR(PoseJudge(question()).judge(off_by(3, true)).over_bound, 3 / std::sqrt(6.0), 1e-3);
}

TEST_F(Judged, AWiderClaimIsRightFurtherOffButNoPeerIs) {
  PoseAnswer answer = off_by(20, true);
  EXPECT_EQ(outcome(answer), StabilityOutcome::wrong_and_silent);
  *answer.covariance *= 16;
  EXPECT_EQ(outcome(answer), StabilityOutcome::right_and_said);
  PoseQuestion by_bound = question();
  by_bound.by_bound = true;
  EXPECT_EQ(outcome(answer, by_bound), StabilityOutcome::wrong_and_silent);
}

TEST_F(Judged, AnotherOfTheAnswersMayBeTheTruth) {
  PoseAnswer answer = off_by(20, true);
  const Pose truth = question().task.camera_from_target,
             wrong = off_by(-20, true).camera_from_target;
  answer.alternatives = {{wrong, *answer.covariance}, {truth, *answer.covariance}};
  EXPECT_EQ(outcome(answer), StabilityOutcome::wrong_and_said);
  answer.alternatives.pop_back();
  EXPECT_EQ(outcome(answer), StabilityOutcome::wrong_and_silent);
}

TEST_F(Judged, RefusedWhatCouldBeKnownAndWhatNot) {
  EXPECT_EQ(outcome({}), StabilityOutcome::right_but_refused);
  PoseQuestion q = question();
  q.task.sigma_px = 20;
  EXPECT_EQ(outcome({}, q), StabilityOutcome::wrong_and_said);
  q = question();
  q.right = {0, 1, 2};
  EXPECT_EQ(outcome({}, q), StabilityOutcome::wrong_and_said);
  q.right.clear();  // no truth: any answer is wrong
  EXPECT_EQ(outcome(off_by(0, true), q), StabilityOutcome::wrong_and_silent);
}

TEST_F(Judged, GrossErrorsAndNumbersThatAreNone) {
  PoseQuestion q = question();
  q.task.sigma_px = 500;  // a bound that excludes nothing
  PoseAnswer answer = off_by(0, false);
  const Pose truth = q.task.camera_from_target;
  EXPECT_EQ(outcome(answer, q), StabilityOutcome::right_and_said);
  answer.camera_from_target =
      Pose(exp_rotation({0, 0, 0.6}) * truth.rotation(), truth.translation());
  EXPECT_EQ(outcome(answer, q), StabilityOutcome::wrong_and_silent);
  answer.camera_from_target = Pose(truth.rotation(), -truth.translation());
  EXPECT_EQ(outcome(answer, q), StabilityOutcome::wrong_and_silent);
  answer.camera_from_target = Pose(truth.rotation(), {NAN, 0, 1});
  EXPECT_EQ(outcome(answer, q), StabilityOutcome::wrong_and_silent);
}

TEST_F(Judged, TheOriginOfTheTargetDoesNotMatter) {
  PoseQuestion moved = question();
  const Eigen::Vector3d offset(3, -2, 5);
  for (Correspondence& c : moved.task.correspondences) c.point += offset;
  const auto shifted = [&](const Pose& pose) {
    return Pose(pose.rotation(), pose.translation() - pose.rotation() * offset);
  };
  moved.task.camera_from_target = shifted(moved.task.camera_from_target);
  PoseAnswer answer = off_by(4, false);
  answer.camera_from_target = shifted(answer.camera_from_target);
  EXPECT_NEAR(PoseJudge(moved).judge(answer).over_bound, 4 / std::sqrt(6.0), 1e-2);
}

TEST(StabilityCsv, OneRowACellAndMethod) {
  const StabilityMap map = scripted_map();
  const std::string csv = stability_csv(map, run_map(map, {}));
  EXPECT_TRUE(csv.starts_with(
      "map,x,y,method,trials,right_and_said,wrong_and_said,wrong_and_silent,right_but_refused,"
      "rms_over_bound,median_over_bound,flips,time_us,said,first_silent,first_refused\n"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  EXPECT_HAS(csv, "\nscripted,10,\"two, so\",peer,4,");
  EXPECT_EQ(stability_csv(map, read_stability(map, csv)), csv);
  EXPECT_THROW(read_stability(map, csv.substr(0, csv.rfind("scripted"))), Error);
  EXPECT_THROW(read_stability(ours_alone(map), csv), Error);
}

TEST(Atlas, PageAndPictureSayWhatTheResultSays) {
  StabilityMap map = scripted_map();
  map.what = "Something happens", map.why = "It must", map.answer = "It does";
  map.exempt = {"what cannot be seen"};
  StabilityResult result{map.name, 1, {}};
  for (std::size_t cell = 0; cell < 6; ++cell)
    for (std::size_t method = 0; method < 2; ++method) {
      StabilityTally& t = result.tallies.emplace_back();
      t.cell = cell, t.method = method, t.trials = 1000, t.count = {1000, 0, 0, 0};
    }
  result.tallies[9].count = {300, 0, 700, 0};  // cell 4, the peer
  const std::vector<std::string> origin = {"by hand"};
  const std::vector<AtlasSheet> sheets = {{map, result}};
  std::string page = atlas_page(sheets, origin);
  EXPECT_HAS(page,
             "peer is wrong and silent in 11.7 % of all trials, and in 70 % at tilt 10 deg, "
             "two, so");
  EXPECT_HAS(page, "## Cells that miss the marks\n\nNone.");
  EXPECT_HAS(page, "![scripted](scripted.png)");
  EXPECT_HAS(page, "what cannot be seen");
  result.tallies[8].count = {999, 0, 1, 0};
  result.tallies[8].first_silent = 17;
  const std::vector<AtlasSheet> missing = {{map, result}};
  page = atlas_page(missing, origin);
  EXPECT_HAS(page,
             "- scripted: tagcal estimate_ours, tilt 10 deg, two, so: wrong and silent 1 of "
             "1000 (the first: trial 17), refused 0");

  const Drawing drawing = atlas_picture(map, result, origin);
  const auto silent = [](const auto& item) {
    const auto* path = std::get_if<Path>(&item);
    return path && path->colour == "#D55E00";
  };
  // Two boxes of cells and one of the legend.
  EXPECT_EQ(std::count_if(drawing.items.begin(), drawing.items.end(), silent), 3);
  EXPECT_TRUE(drawing.has_text("by hand"));
  EXPECT_TRUE(drawing.has_text("two, so"));
}

}  // namespace
}  // namespace tagcal
