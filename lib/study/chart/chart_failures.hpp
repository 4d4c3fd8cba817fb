#pragma once

#include <string>
#include <vector>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// "fails: A 12 %; B 3 %; the others 1 %": the methods that fail in at least 0.5 % of the trials;
// empty if there are none.
std::string failures_text(const ChartResult& result, std::vector<ChartPoint> points);

}  // namespace tagcal::study
