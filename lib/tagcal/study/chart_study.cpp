#include "tagcal/study/chart_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "tagcal/error.hpp"
#include "tagcal/study/processor_time.hpp"
#include "tagcal/study/study_threads.hpp"

namespace tagcal {
namespace {

void check(const ChartOptions& options) {
  const Shard& shard = options.shard;
  if (options.trials < 0) throw Error("trials: must not be negative");
  if (shard.count < 1 || shard.index < 1 || shard.index > shard.count)
    throw Error(
        fmt::format("shard: must be i/n with 1 <= i <= n, got {}/{}", shard.index, shard.count));
}

Random random_of(std::uint64_t seed, int panel, int trial) {
  return {seed, (static_cast<std::uint64_t>(panel) << 32) + static_cast<std::uint64_t>(trial)};
}

// A method that throws, or whose numbers are none, has failed.
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

// One problem of one panel by all of its methods; with the number of the trial another one begins,
// so that none always comes first.
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
  check(options);
  ChartResult result;
  result.error_unit = study.error_unit;
  result.bound_name = study.bound_name;
  result.failure = study.failure;
  result.seed = options.seed;
  result.quick = options.quick;
  result.num_trials = options.trials > 0 ? options.trials
                      : options.quick    ? study.quick_trials
                                         : study.trials;
  result.shards = {options.shard};
  result.methods = study.methods;
  for (const StudyPanel& panel : study.panels) result.panels.push_back(panel.panel);

  const int panels = static_cast<int>(study.panels.size());
  std::vector<int> mine;
  for (int t = options.shard.index - 1; t < result.num_trials; t += options.shard.count)
    mine.push_back(t);
  // Trial by trial through all panels: a slow moment of the machine hits all of them.
  const int n = panels * static_cast<int>(mine.size());
  std::vector<std::vector<ChartTrial>> done(static_cast<std::size_t>(n));
  std::mutex mutex;
  int num_done = 0;
  const OneOpenCvThread one_thread;
  in_threads(n, options.threads, [&](int i) {
    const int panel = i % panels, trial = i / panels;
    done[static_cast<std::size_t>(panel) * mine.size() + static_cast<std::size_t>(trial)] =
        attempt_all(study, panel, mine[static_cast<std::size_t>(trial)], options.seed);
    const std::scoped_lock lock(mutex);
    if (progress) progress(++num_done, n);
  });
  for (const auto& trials : done)
    result.trials.insert(result.trials.end(), trials.begin(), trials.end());
  return result;
}

}  // namespace tagcal
