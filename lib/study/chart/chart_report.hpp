#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "study/chart/chart.hpp"
#include "study/plot/drawing.hpp"

namespace tagcal::study {

// All trials of a result with their origin: lines "# key: value", then
// `panel,method,trial,time_us,error,error_over_bound`; the errors are empty if the method failed.
// Panels and methods are numbered from 0 in the order of their lines.
std::string trials_text(const ChartResult& result);

// The points as CSV: job,method,panel,time_us,rms,rms_over_bound,failures,trials. One row per
// method and panel; time is the median, errors are empty if all trials failed.
std::string points_csv(const ChartResult& result, std::span<const ChartPoint> points);

// A page in Markdown: our methods compared with the peers in each panel, the panels in which they
// are not on the Pareto front, the methods that are not drawn, the settings and the origin.
std::string chart_markdown(const ChartResult& result, std::span<const ChartPoint> points);

struct ChartPicture {
  std::string name;  // of its file, without the ending
  Drawing drawing;
};

// The pages of a result: chart, chart-2, .. Each panel has the time on the horizontal and the error
// over the bound on the vertical axis (both logarithmic), whiskers from 5 to 95 %, the Pareto front
// and the bound as lines. 900 px wide.
std::vector<ChartPicture> chart_pictures(const ChartResult& result,
                                         std::span<const ChartPoint> points);

// A method whose share of failures exceeds that of the most reliable method of its panel by more
// than this is not compared: its answers are for other problems.
inline constexpr double kMoreFailures = 0.05;

// The points of one panel that are compared, as indices into `panel`, by growing time.
std::vector<std::size_t> comparable(std::span<const ChartPoint> panel);

// The Pareto front of these points in median time and RMS over bound, by growing time: no other
// point is better in one of the two and at least as good in the other.
std::vector<std::size_t> pareto_front(std::span<const ChartPoint> panel);

// One of our methods compared with the peers of its panel.
struct Standing {
  ChartPoint ours;
  bool compared = false;                   // by reliability
  bool on_front = false;                   // no peer dominates it
  std::optional<ChartPoint> dominated_by;  // the most accurate of the peers that are better in both
  double fewest_failures = 0;              // of any method in the panel, as a share
  // The fastest peer that is about as accurate (5 %) or better, and about as reliable.
  std::optional<ChartPoint> fastest_equal;
};

// The standings of all our methods in all panels, by panel and method.
std::vector<Standing> standings(const ChartResult& result, std::span<const ChartPoint> points);

// The points of a panel; `points` as from chart_points.
std::vector<ChartPoint> points_of_panel(std::span<const ChartPoint> points, int panel);

}  // namespace tagcal::study
