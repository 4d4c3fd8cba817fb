#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tagcal/study/chart.hpp"

namespace tagcal {

// Every trial of a result with all that it takes to go on from it, so that shards can be merged:
// lines "# key: value", then `panel,method,trial,time_us,error,error_over_bound`, the errors empty
// where the method failed. Panels and methods are numbered from 0 in the order of their lines.
std::string trials_text(const ChartResult& result);

// The inverse. Throws Error that begins with `name`.
ChartResult read_trials(std::string_view text, const std::string& name);

// The points as CSV: job,method,panel,time_us,rms,rms_over_bound,failures,trials. One row a method
// and panel; time is the median, errors are empty where all trials failed.
std::string points_csv(const ChartResult& result, std::span<const ChartPoint> points);

}  // namespace tagcal
