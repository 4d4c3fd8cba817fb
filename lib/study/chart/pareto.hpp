#pragma once

#include <optional>
#include <span>
#include <vector>

#include "study/chart/chart.hpp"

namespace tagcal::study {

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
