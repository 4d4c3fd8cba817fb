#pragma once

#include <string>
#include <vector>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// "fails: A 12 %, B 3 %, the others 1 %" of those that fail in half a percent or more; empty where
// none does.
std::string failures_text(const ChartResult& result, std::vector<ChartPoint> points);

}  // namespace tagcal::study
