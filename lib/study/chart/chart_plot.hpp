#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/chart/chart.hpp"
#include "study/plot/drawing.hpp"

namespace tagcal::study {

struct ChartPicture {
  std::string name;  // of its file, without the ending
  Drawing drawing;
};

// The pages of a result: chart, chart-2, .. Each panel has the time on the horizontal and the error
// over the bound on the vertical axis (both logarithmic), whiskers from 5 to 95 %, the Pareto front
// and the bound as lines. 900 px wide.
std::vector<ChartPicture> chart_pictures(const ChartResult& result,
                                         std::span<const ChartPoint> points);

}  // namespace tagcal::study
