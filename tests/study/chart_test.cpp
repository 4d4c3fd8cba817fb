#include "study/chart/chart.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <tuple>

#include "expect.hpp"
#include "study/chart/chart_report.hpp"
#include "study/chart/chart_study.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
using namespace study;
namespace {

// A study whose errors are the random numbers of its problems.
ChartStudy small_study() {
  ChartStudy study;
  study.error_unit = "nothing";
  study.trials = 12;
  study.quick_trials = 5;
  const std::vector<int> all = {study.number_of({"tagcal right", "", true}),
                                study.number_of({"peer fails", "every time", false}),
                                study.number_of({"peer throws", "", false}),
                                study.number_of({"peer with NaN", "", false})};
  for (const char* name : {"first", "second, with a comma"}) {
    StudyPanel panel{{"", name, "", {"other: cannot"}}, all, {}};
    panel.draw = [](Random& random) {
      const double value = random.uniform(1, 2);
      const auto nothing = [] {};
      return std::vector<Attempt>{{nothing,
                                   [value] {
                                     return Verdict{false, value, 3 * value};
                                   }},
                                  {nothing, [] { return Verdict{}; }},
                                  {[] { throw Error("no"); },
                                   [] {
                                     return Verdict{false, 1, 1};
                                   }},
                                  {nothing, [] {
                                     return Verdict{false, std::nan(""), 1};
                                   }}};
    };
    study.panels.push_back(panel);
  }
  return study;
}

ChartResult run_small(const ChartOptions& options) {
  ChartResult result = run_study(small_study(), options, {});
  result.job = "small";
  return result;
}

void expect_same_errors(const ChartResult& a, const ChartResult& b) {
  ASSERT_EQ(a.trials.size(), b.trials.size());
  for (std::size_t i = 0; i < a.trials.size(); ++i) {
    const ChartTrial &x = a.trials[i], &y = b.trials[i];
    EXPECT_EQ(std::tie(x.panel, x.method, x.trial, x.failed, x.error, x.over_bound),
              std::tie(y.panel, y.method, y.trial, y.failed, y.error, y.over_bound));
  }
}

TEST(Chart, countsFailuresOfEveryKind) {
  const std::vector<ChartPoint> points = chart_points(run_small({}));
  ASSERT_EQ(points.size(), 8u);
  EXPECT_EQ(points[0].failures, 0);
  EXPECT_EQ(points[0].trials, 12);
  EXPECT_GT(points[0].rms, 1);
  EXPECT_LT(points[0].rms, 2);
  EXPECT_DOUBLE_EQ(points[0].rms_over_bound, 3 * points[0].rms);
  EXPECT_LE(points[0].over_bound.low, points[0].over_bound.median);
  EXPECT_LT(points[0].over_bound.low, points[0].over_bound.high);
  for (const std::size_t failing : {1u, 2u, 3u}) {
    EXPECT_EQ(points[failing].failures, 12) << failing;
    EXPECT_TRUE(std::isnan(points[failing].rms));
  }
}

TEST(Chart, errorsDoNotDependOnThreadsButOnTheSeed) {
  const ChartResult one = run_small({.trials = 7}), three = run_small({.trials = 7, .threads = 3});
  expect_same_errors(one, three);
  const ChartResult other = run_small({.trials = 7, .seed = 2});
  EXPECT_NE(one.trials[0].error, other.trials[0].error);
  EXPECT_NE(one.trials[0].error, one.trials[4].error);  // another trial, another problem
}

TEST(Chart, quickHasFewerTrials) { EXPECT_EQ(run_small({.quick = true}).num_trials, 5); }

TEST(Chart, trialsAsCsv) {
  ChartResult result = run_small({.trials = 5});
  result.origin = {"made here: today"};
  const std::string text = trials_text(result);
  EXPECT_HAS(text, "# seed: 1\n");
  EXPECT_HAS(text, "# origin: made here: today\n");
  const std::size_t header = text.find("panel,method,trial,time_us,error,error_over_bound\n");
  ASSERT_NE(header, std::string::npos);
  EXPECT_EQ(std::count(text.begin() + static_cast<std::ptrdiff_t>(header), text.end(), '\n'),
            1 + static_cast<std::ptrdiff_t>(result.trials.size()));
}

TEST(Chart, refusesNegativeTrials) { EXPECT_THROW(run_small({.trials = -1}), Error); }

TEST(Chart, pointsAsCsv) {
  const ChartResult result = run_small({.trials = 3});
  std::istringstream lines(points_csv(result, chart_points(result)));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "job,method,panel,time_us,rms,rms_over_bound,failures,trials");
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("small,tagcal right,first,")) << line;
  EXPECT_TRUE(line.ends_with(",0,3")) << line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("small,peer fails,first,")) << line;
  EXPECT_TRUE(line.ends_with(",,,3,3")) << line;
  std::vector<std::string> rows;
  while (std::getline(lines, line)) rows.push_back(line);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_TRUE(rows.back().starts_with("small,peer with NaN,\"second, with a comma\","));
}

ChartPoint point(double time_us, double error, int failures = 0, int method = 0) {
  ChartPoint p;
  p.method = method;
  p.time_us.median = time_us;
  p.rms_over_bound = error;
  p.failures = failures;
  p.trials = 100;
  return p;
}

TEST(Pareto, keepsWhatNothingBeatsInBoth) {
  const std::vector<ChartPoint> panel = {point(10, 1.0), point(1, 3.0),  point(2, 3.5),
                                         point(5, 1.5),  point(20, 1.0), point(5, 1.5)};
  EXPECT_EQ(pareto_front(panel), (std::vector<std::size_t>{1, 3, 5, 0}));
}

TEST(Pareto, comparesOnlyWhatIsAboutAsReliable) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<ChartPoint> panel = {point(10, 1.0, 2), point(1, 0.5, 8), point(3, 2, 7),
                                         point(0.1, nan, 100)};
  EXPECT_EQ(comparable(panel), (std::vector<std::size_t>{2, 0}));
  EXPECT_EQ(pareto_front(panel), (std::vector<std::size_t>{2, 0}));
}

TEST(Pareto, saysHowOursStands) {
  ChartResult result;
  result.methods = {{"tagcal a", "", true}, {"peer b", "", false}, {"peer c", "", false}};
  result.panels = {{"", "one", "", {}}, {"", "two", "", {}}};
  std::vector<ChartPoint> points = {point(10, 1.0, 0, 0), point(20, 1.04, 0, 1),
                                    point(40, 1.0, 0, 2), point(10, 1.2, 0, 0),
                                    point(5, 1.0, 0, 1),  point(1, 1.1, 50, 2)};
  for (std::size_t i = 3; i < 6; ++i) points[i].panel = 1;
  const std::vector<Standing> all = standings(result, points);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_TRUE(all[0].on_front);
  ASSERT_TRUE(all[0].fastest_equal);
  EXPECT_EQ(all[0].fastest_equal->method, 1);
  EXPECT_FALSE(all[1].on_front);
  ASSERT_TRUE(all[1].dominated_by);
  EXPECT_EQ(all[1].dominated_by->method, 1);
  const std::string page = chart_markdown(result, points);
  EXPECT_HAS(page, "two: tagcal a (10 µs, 1.200 bounds, fails 0 %) is behind peer b");
}

TEST(ChartPlot, drawsEveryPage) {
  ChartStudy study = small_study();
  study.panels[1].panel.page = "it's another";
  ChartResult result = run_study(study, {.trials = 2}, {});
  const auto pictures = chart_pictures(result, chart_points(result));
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_EQ(pictures[0].name, "chart");
  EXPECT_EQ(pictures[1].name, "chart-2");
  EXPECT_TRUE(pictures[1].drawing.has_text("it's another"));
  EXPECT_TRUE(pictures[0].drawing.has_text("fails: peer fails 100\u00a0%"));
  EXPECT_TRUE(pictures[0].drawing.has_text(result.methods[0].name));
}

}  // namespace
}  // namespace tagcal
