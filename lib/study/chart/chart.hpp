#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Speed against accuracy: all methods of a job, ours and the peers', solve the same random
// problems.

namespace tagcal::study {

enum class ChartJob { pose, focal, project, calibrate, corners, rig, handeye };

// pose, focal, project, calibrate, corners, rig, handeye: in the order of ChartJob.
std::span<const std::string_view> chart_job_names();
std::optional<ChartJob> chart_job(std::string_view name);

// The peers that this was built with: "OpenCV 4.6.0".
std::string peers_versions();

struct ChartOptions {
  int trials = 0;  // of each panel; 0: what the job takes, or with `quick`
  std::uint64_t seed = 1;
  int threads = 1;     // 0: one a core. Errors do not depend on it
  bool quick = false;  // fewer trials and smaller problems
};

struct ChartMethod {
  std::string name;
  std::string settings;  // how it was called
  bool ours = false;
  bool operator==(const ChartMethod&) const = default;
};

// One class of problems. Panels of one page stand in rows and columns by these titles.
struct ChartPanel {
  std::string page, row, column;
  std::vector<std::string> cannot;  // methods that are not drawn: "OpenCV P3P: takes four points"

  std::string name() const;  // the titles that are not empty, by ", "
  bool operator==(const ChartPanel&) const = default;
};

// One method at one problem.
struct ChartTrial {
  int panel = 0, method = 0, trial = 0;
  double time_us = 0;  // of the thread's processor, without preparation
  bool failed = false;
  double error = 0;  // in ChartResult::error_unit; 0 where it failed
  // sqrt(e' F e / p) of its p errors e, F the information at the truth; for errors in pixels
  // (project, corners), their RMS over that of the bound
  double over_bound = 0;
};

struct ChartResult {
  std::string job;
  std::string error_unit;  // what `error` is: "rotation, degrees"
  std::string bound_name;  // the unit of over_bound
  std::string failure;     // condition of a failed trial: "no answer, or .."
  std::uint64_t seed = 0;
  bool quick = false;
  int num_trials = 0;               // of each panel
  std::vector<std::string> origin;  // "machine: ..", ..; the caller fills it in
  std::vector<ChartMethod> methods;
  std::vector<ChartPanel> panels;
  std::vector<ChartTrial> trials;  // by panel, trial and method
};

// Runs a job. `progress(done, total)` is called under a lock. Problems depend on the seed, the
// panel and the number of the trial alone. Throws Error for options that are out of range.
ChartResult run_chart(ChartJob job, const ChartOptions& options,
                      const std::function<void(int, int)>& progress = {});

// The median and the 5 and 95 % points.
struct Spread {
  double median = 0, low = 0, high = 0;
};

// All trials of one method in one panel.
struct ChartPoint {
  int panel = 0, method = 0;
  Spread time_us;
  double rms = 0;             // of `error`; NaN where all failed
  double rms_over_bound = 0;  // likewise
  Spread over_bound;          // of the single trials
  int failures = 0, trials = 0;

  double failed_share() const { return trials > 0 ? static_cast<double>(failures) / trials : 0; }
};

// The points by panel and method, in their order. Times include all trials, errors only those that
// did not fail.
std::vector<ChartPoint> chart_points(const ChartResult& result);

}  // namespace tagcal::study
