#pragma once

#include <optional>
#include <span>
#include <vector>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// A method that fails by more of all trials than the most reliable one of its panel is not compared
// with the others: it has answers for other problems.
inline constexpr double kMoreFailures = 0.05;

// The points of one panel that are compared, by growing time; indices into `panel`.
std::vector<std::size_t> comparable(std::span<const ChartPoint> panel);

// The Pareto front of them by median time and RMS over bound: the points than which no other is
// both faster and more accurate (or one of them, and equal in the other). By growing time.
std::vector<std::size_t> pareto_front(std::span<const ChartPoint> panel);

// How one of our methods stands in its panel.
struct Standing {
  ChartPoint ours;
  bool compared = false;                   // by reliability
  bool on_front = false;                   // before the peers
  std::optional<ChartPoint> dominated_by;  // the most accurate of the peers that are better in both
  double fewest_failures = 0;              // of any method in the panel, as a share
  // The fastest peer that is about as accurate (5 %) or better, and about as reliable.
  std::optional<ChartPoint> fastest_equal;
};

// Of all methods of ours in all panels, by panel and method.
std::vector<Standing> standings(const ChartResult& result, std::span<const ChartPoint> points);

// The points of a panel; `points` as from chart_points.
std::vector<ChartPoint> points_of_panel(std::span<const ChartPoint> points, int panel);

}  // namespace tagcal::study
