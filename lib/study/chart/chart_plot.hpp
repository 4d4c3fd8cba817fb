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

// The pages of a result, each as SVG and PNG: chart.svg and chart.png the first, chart-2.svg and so
// on the others. Small multiples: time across, error over bound up (both logarithmic), whiskers
// from 5 to 95 %, the Pareto front and the bound as lines; 900 px wide, PNG at twice that.
std::vector<ChartPicture> chart_pictures(const ChartResult& result,
                                         std::span<const ChartPoint> points);

}  // namespace tagcal::study
