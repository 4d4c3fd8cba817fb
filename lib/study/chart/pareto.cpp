#include "study/chart/chart_report.hpp"

#include <algorithm>
#include <cmath>

namespace tagcal::study {
namespace {

constexpr double kEquallyAccurate = 1.05;

bool dominates(const ChartPoint& a, const ChartPoint& b) {
  const double ta = a.time_us.median, tb = b.time_us.median;
  return ta <= tb && a.rms_over_bound <= b.rms_over_bound &&
         (ta < tb || a.rms_over_bound < b.rms_over_bound);
}

double fewest_failures(std::span<const ChartPoint> panel) {
  double fewest = 1;
  for (const ChartPoint& p : panel) fewest = std::min(fewest, p.failed_share());
  return fewest;
}

Standing standing_of(const ChartPoint& ours, std::span<const ChartPoint> peers, bool compared) {
  Standing standing{ours, compared, compared, {}, 0, {}};
  for (const ChartPoint& peer : peers) {
    if (compared && dominates(peer, ours)) {
      standing.on_front = false;
      if (!standing.dominated_by || peer.rms_over_bound < standing.dominated_by->rms_over_bound)
        standing.dominated_by = peer;
    }
    const bool equal = peer.rms_over_bound <= kEquallyAccurate * ours.rms_over_bound;
    if (equal &&
        (!standing.fastest_equal || peer.time_us.median < standing.fastest_equal->time_us.median))
      standing.fastest_equal = peer;
  }
  return standing;
}

}  // namespace

std::vector<std::size_t> comparable(std::span<const ChartPoint> panel) {
  const double fewest = fewest_failures(panel);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < panel.size(); ++i)
    if (std::isfinite(panel[i].rms_over_bound) && panel[i].failed_share() <= fewest + kMoreFailures)
      kept.push_back(i);
  std::sort(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) {
    return panel[a].time_us.median < panel[b].time_us.median;
  });
  return kept;
}

std::vector<std::size_t> pareto_front(std::span<const ChartPoint> panel) {
  const std::vector<std::size_t> kept = comparable(panel);
  std::vector<std::size_t> front;
  for (const std::size_t i : kept) {
    const auto better = [&](std::size_t j) { return dominates(panel[j], panel[i]); };
    if (std::none_of(kept.begin(), kept.end(), better)) front.push_back(i);
  }
  return front;
}

std::vector<ChartPoint> points_of_panel(std::span<const ChartPoint> points, int panel) {
  std::vector<ChartPoint> some;
  for (const ChartPoint& p : points)
    if (p.panel == panel) some.push_back(p);
  return some;
}

std::vector<Standing> standings(const ChartResult& result, std::span<const ChartPoint> points) {
  const auto is_ours = [&](const ChartPoint& p) {
    return result.methods[static_cast<std::size_t>(p.method)].ours;
  };
  std::vector<Standing> all;
  for (std::size_t i = 0; i < result.panels.size(); ++i) {
    const std::vector<ChartPoint> panel = points_of_panel(points, static_cast<int>(i));
    const std::vector<std::size_t> kept = comparable(panel);
    std::vector<ChartPoint> peers;
    for (const std::size_t k : kept)
      if (!is_ours(panel[k])) peers.push_back(panel[k]);
    for (std::size_t k = 0; k < panel.size(); ++k)
      if (is_ours(panel[k]))
        all.push_back(
            standing_of(panel[k], peers, std::find(kept.begin(), kept.end(), k) != kept.end()));
  }
  return all;
}

}  // namespace tagcal::study
