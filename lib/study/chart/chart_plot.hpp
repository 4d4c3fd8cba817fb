#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// A picture as a script for gnuplot (5.4), which writes it to its standard output.
struct ChartPicture {
  std::string file_name;
  std::string script;
};

// The pages of a result as SVG and PNG: chart.svg, chart.png, chart-2.svg, .. Each panel has the
// time on the horizontal and the error over the bound on the vertical axis (both logarithmic),
// whiskers from 5 to 95 %, the Pareto front and the bound as lines. SVG 900 px wide, PNG twice as
// wide.
std::vector<ChartPicture> chart_pictures(const ChartResult& result,
                                         std::span<const ChartPoint> points);

}  // namespace tagcal::study
