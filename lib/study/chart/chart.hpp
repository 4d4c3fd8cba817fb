#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Speed against accuracy: every method of a job, ours and the peers', on the same seeded problems.

namespace tagcal::study {

enum class ChartJob { pose, focal, project, calibrate, corners };

// pose, focal, project, calibrate, corners: in the order of ChartJob.
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
  std::vector<std::string> cannot;  // what is not drawn, and why: "OpenCV P3P: takes four points"

  std::string name() const;  // the titles that are not empty, by ", "
  bool operator==(const ChartPanel&) const = default;
};

// One method at one problem.
struct ChartTrial {
  int panel = 0, method = 0, trial = 0;
  double time_us = 0;  // of the thread's processor, preparation left out
  bool failed = false;
  double error = 0;  // in ChartResult::error_unit; 0 where it failed
  // sqrt(e' F e / p) of its p errors e, F the information at the truth; where the errors all are
  // pixels (project, corners), their RMS over that of the bound
  double over_bound = 0;
};

struct ChartResult {
  std::string job;
  std::string error_unit;  // what `error` is: "rotation, degrees"
  std::string bound_name;  // what over_bound is a multiple of
  std::string failure;     // when a trial fails: "no answer, or .."
  std::uint64_t seed = 0;
  bool quick = false;
  int num_trials = 0;               // of each panel
  std::vector<std::string> origin;  // what made it, as "machine: ..": for the caller to fill
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

// By panel and method, in their order. Times are those of all trials, errors those of the others
// than failures.
std::vector<ChartPoint> chart_points(const ChartResult& result);

}  // namespace tagcal::study
