#include "study/chart/chart_study.hpp"

#include <algorithm>
#include <cmath>

#include "study/harness/study.hpp"
#include "study/processor_time.hpp"
#include "tagcal/error.hpp"

namespace tagcal::study {
namespace {

// A method that throws, or whose errors are not finite, has failed.
ChartTrial attempted(const Attempt& attempt) {
  ChartTrial done;
  Verdict verdict;
  try {
    done.time_us = processor_us(attempt.solve);
    verdict = attempt.answer();
  } catch (const std::exception&) {
    verdict = {};
  }
  const bool number = std::isfinite(verdict.error) && std::isfinite(verdict.over_bound);
  done.failed = verdict.failed || !number;
  if (!done.failed) done.error = verdict.error, done.over_bound = verdict.over_bound;
  return done;
}

// Solves one problem of a panel by all its methods: a row each. The first method changes with the
// number of the trial, so that none is always the first.
std::vector<Values> attempt_all(const StudyPanel& panel, Random random, std::uint64_t trial) {
  const std::vector<Attempt> attempts = panel.draw(random);
  std::vector<Values> rows(attempts.size());
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    const std::size_t m = (i + trial) % attempts.size();
    const ChartTrial done = attempted(attempts[m]);
    rows[m] = {static_cast<double>(panel.methods[m]), done.time_us, done.failed ? 1. : 0.,
               done.error, done.over_bound};
  }
  return rows;
}

ChartTrial trial_of(const Row& row) {
  const auto number = [&](std::size_t i) { return std::get<double>(row.values[i]); };
  return {std::stoi(row.task),
          static_cast<int>(number(0)),
          static_cast<int>(row.trial),
          number(1),
          number(2) != 0,
          number(3),
          number(4)};
}

ChartStudy study_of(ChartJob job, bool quick) {
  switch (job) {
    case ChartJob::pose:
      return pose_study();
    case ChartJob::focal:
      return focal_study();
    case ChartJob::project:
      return project_study();
    case ChartJob::calibrate:
      return calibrate_study(quick);
    case ChartJob::corners:
      return corners_study();
    case ChartJob::rig:
      return rig_study(quick);
    case ChartJob::handeye:
      return handeye_chart(quick);
  }
  return {};
}

}  // namespace

int ChartStudy::number_of(const ChartMethod& method) {
  const auto found = std::find_if(methods.begin(), methods.end(),
                                  [&](const ChartMethod& m) { return m.name == method.name; });
  if (found != methods.end()) return static_cast<int>(found - methods.begin());
  methods.push_back(method);
  return static_cast<int>(methods.size()) - 1;
}

ChartResult run_study(const ChartStudy& study, const ChartOptions& options,
                      const std::function<void(int, int)>& progress) {
  if (options.trials < 0) throw Error("trials: must not be negative");
  ChartResult result;
  result.error_unit = study.error_unit;
  result.bound_name = study.bound_name;
  result.failure = study.failure;
  result.seed = options.seed;
  result.quick = options.quick;
  result.num_trials = options.trials > 0 ? options.trials
                      : options.quick    ? study.quick_trials
                                         : study.trials;
  result.methods = study.methods;
  for (const StudyPanel& panel : study.panels) result.panels.push_back(panel.panel);

  const auto tasks = [&](const StudyOptions&) {
    std::vector<Task> all;
    for (std::size_t i = 0; i < study.panels.size(); ++i)
      all.push_back({std::to_string(i), [&, i](std::uint64_t trial) {
                       return attempt_all(study.panels[i],
                                          {options.seed, (std::uint64_t{i} << 32) + trial}, trial);
                     }});
    return all;
  };
  const Study loop{.name = "chart",
                   .summary = "",
                   .columns = {"method", "time_us", "failed", "error", "over_bound"},
                   .tasks = tasks};
  for (const Row& row : run_study(
           loop, {.first = 0, .count = result.num_trials, .threads = options.threads}, progress))
    result.trials.push_back(trial_of(row));
  return result;
}

ChartResult run_chart(ChartJob job, const ChartOptions& options,
                      const std::function<void(int, int)>& progress) {
  ChartResult result = run_study(study_of(job, options.quick), options, progress);
  result.job = chart_job_names()[static_cast<std::size_t>(job)];
  return result;
}

}  // namespace tagcal::study
