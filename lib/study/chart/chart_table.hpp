#pragma once

#include <span>
#include <string>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// A page in Markdown: our methods compared with the peers in each panel, the panels in which they
// are not on the Pareto front, the methods that are not drawn, the settings and the origin.
std::string chart_markdown(const ChartResult& result, std::span<const ChartPoint> points);

}  // namespace tagcal::study
