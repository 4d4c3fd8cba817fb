#include "study/chart/chart_report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tagcal::study {
namespace {

std::string percent(double share) {
  return fmt::format("{:.{}f}\u00a0%", 100 * share,
                     share < 0.1 ? 1 : 0);  // the space does not break
}

std::string short_name(const ChartResult& result, const ChartPoint& p) {
  std::string name = result.methods[static_cast<std::size_t>(p.method)].name;
  if (name.starts_with("OpenCV ")) name = name.substr(7);
  return name.substr(0, name.find(" ("));
}

}  // namespace

std::string failures_text(const ChartResult& result, std::vector<ChartPoint> points) {
  std::stable_sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) {
    return a.failed_share() > b.failed_share();
  });
  if (points.empty() || points.front().failed_share() < 0.005) return "";
  const std::string least = percent(points.back().failed_share());
  std::string all = "fails: ";
  int with_least = 0;
  for (const ChartPoint& p : points) {
    if (percent(p.failed_share()) == least && points.size() > 1)
      ++with_least;
    else if (p.failed_share() >= 0.005)
      all += fmt::format("{} {}; ", short_name(result, p), percent(p.failed_share()));
  }
  if (with_least > 0 && points.back().failed_share() >= 0.005)
    all += fmt::format("{} {}; ",
                       with_least == 1 ? short_name(result, points.back()) : "the others", least);
  return all.substr(0, all.size() - 2);
}

}  // namespace tagcal::study
