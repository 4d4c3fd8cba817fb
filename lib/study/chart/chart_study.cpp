#include "study/chart/chart_study.hpp"

#include <algorithm>
#include <cmath>

#include "study/processor_time.hpp"
#include "study/study_threads.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

Random random_of(std::uint64_t seed, int panel, int trial) {
  return {seed, (static_cast<std::uint64_t>(panel) << 32) + static_cast<std::uint64_t>(trial)};
}

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

// Solves one problem of a panel by all its methods. The first method changes with the number of the
// trial, so that none is always the first.
std::vector<ChartTrial> attempt_all(const ChartStudy& study, int panel, int trial,
                                    std::uint64_t seed) {
  const StudyPanel& what = study.panels[static_cast<std::size_t>(panel)];
  Random random = random_of(seed, panel, trial);
  const std::vector<Attempt> attempts = what.draw(random);
  std::vector<ChartTrial> done(attempts.size());
  for (std::size_t i = 0; i < attempts.size(); ++i) {
    const std::size_t m = (i + static_cast<std::size_t>(trial)) % attempts.size();
    done[m] = attempted(attempts[m]);
    done[m].panel = panel, done[m].method = what.methods[m], done[m].trial = trial;
  }
  return done;
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

  const int panels = static_cast<int>(study.panels.size());
  const auto num_trials = static_cast<std::size_t>(result.num_trials);
  // Each trial visits all panels, so that a slow moment of the machine affects all of them.
  std::vector<std::vector<ChartTrial>> done(study.panels.size() * num_trials);
  const OneOpenCvThread one_thread;
  const auto visit = [&](std::size_t i) {
    const int panel = static_cast<int>(i) % panels, trial = static_cast<int>(i) / panels;
    done[static_cast<std::size_t>(panel) * num_trials + static_cast<std::size_t>(trial)] =
        attempt_all(study, panel, trial, options.seed);
  };
  parallel_for(done.size(), options.threads, visit, progress);
  for (const auto& trials : done)
    result.trials.insert(result.trials.end(), trials.begin(), trials.end());
  return result;
}

ChartResult run_chart(ChartJob job, const ChartOptions& options,
                      const std::function<void(int, int)>& progress) {
  ChartResult result = run_study(study_of(job, options.quick), options, progress);
  result.job = chart_job_names()[static_cast<std::size_t>(job)];
  return result;
}

}  // namespace tagcal::study
