#pragma once

#include <span>
#include <string>

#include "study/chart/chart.hpp"

namespace tagcal::study {

// All trials of a result with their origin: lines "# key: value", then
// `panel,method,trial,time_us,error,error_over_bound`; the errors are empty if the method failed.
// Panels and methods are numbered from 0 in the order of their lines.
std::string trials_text(const ChartResult& result);

// The points as CSV: job,method,panel,time_us,rms,rms_over_bound,failures,trials. One row per
// method and panel; time is the median, errors are empty if all trials failed.
std::string points_csv(const ChartResult& result, std::span<const ChartPoint> points);

}  // namespace tagcal::study
