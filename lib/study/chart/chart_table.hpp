#pragma once

#include <span>
#include <string>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// A page in Markdown: how ours stands against the peers in each panel, where it is not on the
// Pareto front and by how much, what is not drawn, the settings and the origin.
std::string chart_markdown(const ChartResult& result, std::span<const ChartPoint> points);

}  // namespace tagcal::study
