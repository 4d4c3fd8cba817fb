#include "study/atlas/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "study/harness/study.hpp"
#include "study/processor_time.hpp"
#include "study/quantile.hpp"
#include "tagcal/error.hpp"

namespace tagcal::study {
namespace {

// One method at one problem.
struct Trial {
  StabilityVerdict verdict;
  double time_us = 0;
};

Trial tried(const Prepared<StabilityVerdict>& attempt) {
  Trial trial;
  trial.time_us = processor_us(attempt.solve);
  trial.verdict = attempt.answer();
  return trial;
}

struct Numbers {
  int ours = 0, peers = 0;
  int of(const StabilityMethod& method) const { return method.ours ? ours : peers; }
};

Numbers numbers_of(const StabilityMap& map, const StabilityOptions& options) {
  if (options.trials < 0) throw Error("trials: must not be negative");
  if (options.threads < 0) throw Error("threads: must not be negative");
  for (const std::size_t cell : options.cells)
    if (cell >= map.num_cells())
      throw Error(fmt::format("cells: {} has no cell {}", map.name, cell));
  Numbers n{map.trials, map.peer_trials};
  if (options.quick) n = {map.quick_trials, map.quick_trials};
  if (options.trials > 0) n = {options.trials, std::min(options.trials, n.peers)};
  return n;
}

StabilityTally tally_of(std::span<const Trial> trials) {
  StabilityTally tally;
  std::vector<double> times, over_bound;
  double squares = 0;
  int right = 0;
  for (const auto& [verdict, time_us] : trials) {
    times.push_back(time_us);
    ++tally.count[static_cast<std::size_t>(verdict.outcome)];
    ++tally.said[verdict.said];
    tally.flips += verdict.flipped;
    if (verdict.outcome == StabilityOutcome::wrong_and_silent && tally.first_silent < 0)
      tally.first_silent = tally.trials;
    if (verdict.outcome == StabilityOutcome::right_but_refused && tally.first_refused < 0)
      tally.first_refused = tally.trials;
    ++tally.trials;
    if (!std::isfinite(verdict.over_bound)) continue;
    over_bound.push_back(verdict.over_bound);
    if (verdict.outcome != StabilityOutcome::right_and_said) continue;
    squares += verdict.over_bound * verdict.over_bound;
    ++right;
  }
  tally.rms_over_bound = std::sqrt(squares / right);  // of none: NaN
  tally.median_over_bound = quantile(over_bound, 0.5);
  tally.time_us = quantile(times, 0.5);
  return tally;
}

// The methods that still have this trial, a row each.
std::vector<Values> attempt_all(const StabilityMap& map, const Numbers& n, std::size_t cell,
                                std::uint64_t seed, std::uint64_t trial) {
  Random random(seed, (static_cast<std::uint64_t>(cell) << 32) + trial);
  const std::vector<double> at = map.values(cell);
  const StabilityProblem problem = map.draw(at, random);
  std::vector<Values> rows;
  for (std::size_t m = 0; m < map.methods.size(); ++m) {
    if (trial >= static_cast<std::uint64_t>(n.of(map.methods[m]))) continue;
    const auto [verdict, time_us] = tried(problem(m));
    rows.push_back({static_cast<double>(m), static_cast<double>(verdict.outcome),
                    verdict.over_bound, verdict.flipped ? 1. : 0., verdict.said, time_us});
  }
  return rows;
}

// Runs all methods in a cell; one tally per method.
std::vector<StabilityTally> run_cell(const StabilityMap& map, std::size_t cell,
                                     const StabilityOptions& options) {
  const Numbers n = numbers_of(map, options);
  const Study loop{.name = map.name,
                   .summary = "",
                   .columns = {"method", "outcome", "over_bound", "flipped", "said", "time_us"},
                   .tasks = [&](const StudyOptions&) {
                     return std::vector<Task>{{map.cell_label(cell), [&](std::uint64_t trial) {
                                                 return attempt_all(map, n, cell, options.seed,
                                                                    trial);
                                               }}};
                   }};
  std::vector<std::vector<Trial>> done(map.methods.size());
  const StudyOptions all{
      .first = 0, .count = std::max(n.ours, n.peers), .threads = options.threads};
  for (const Row& row : run_study(loop, all)) {
    const auto number = [&](std::size_t i) { return std::get<double>(row.values[i]); };
    done[static_cast<std::size_t>(number(0))].push_back(
        {{static_cast<StabilityOutcome>(number(1)), number(2), number(3) != 0,
          std::get<std::string>(row.values[4])},
         number(5)});
  }
  std::vector<StabilityTally> tallies;
  for (std::size_t m = 0; m < done.size(); ++m) {
    tallies.push_back(tally_of(done[m]));
    tallies.back().cell = cell;
    tallies.back().method = m;
  }
  return tallies;
}

}  // namespace

std::string_view outcome_name(StabilityOutcome outcome) {
  constexpr std::string_view kNames[kNumOutcomes] = {"right_and_said", "wrong_and_said",
                                                     "wrong_and_silent", "right_but_refused"};
  return kNames[static_cast<std::size_t>(outcome)];
}

std::string StabilityAxis::label(std::size_t i) const {
  return names.empty() ? fmt::format("{:g}", values[i]) : names[i];
}

std::size_t StabilityMap::num_cells() const {
  std::size_t n = 1;
  for (const StabilityAxis& axis : axes) n *= axis.values.size();
  return n;
}

std::vector<std::size_t> StabilityMap::indices(std::size_t cell) const {
  std::vector<std::size_t> result(axes.size());
  for (std::size_t a = axes.size(); a-- > 0;) {
    result[a] = cell % axes[a].values.size();
    cell /= axes[a].values.size();
  }
  return result;
}

std::vector<double> StabilityMap::values(std::size_t cell) const {
  std::vector<double> result;
  const std::vector<std::size_t> index = indices(cell);
  for (std::size_t a = 0; a < axes.size(); ++a) result.push_back(axes[a].values[index[a]]);
  return result;
}

std::string StabilityMap::cell_label(std::size_t cell) const {
  std::string text;
  const std::vector<std::size_t> index = indices(cell);
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (a > 0) text += ", ";
    if (axes[a].names.empty()) text += axes[a].quantity + " ";
    text += axes[a].label(index[a]);
    if (!axes[a].unit.empty()) text += " " + axes[a].unit;
  }
  return text;
}

StabilityMap ours_alone(StabilityMap map) {
  std::vector<std::size_t> kept;
  std::vector<StabilityMethod> methods;
  for (std::size_t m = 0; m < map.methods.size(); ++m)
    if (map.methods[m].ours) kept.push_back(m), methods.push_back(map.methods[m]);
  map.methods = std::move(methods);
  map.draw = [draw = std::move(map.draw), kept](std::span<const double> at,
                                                Random& random) -> StabilityProblem {
    return [problem = draw(at, random), kept](std::size_t method) { return problem(kept[method]); };
  };
  return map;
}

StabilityResult run_map(const StabilityMap& map, const StabilityOptions& options,
                        const std::function<void(int, int)>& progress) {
  numbers_of(map, options);  // throws before anything is done
  StabilityResult result{map.name, options.seed, {}};
  std::vector<std::size_t> cells = options.cells;
  for (std::size_t c = 0; options.cells.empty() && c < map.num_cells(); ++c) cells.push_back(c);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (StabilityTally& tally : run_cell(map, cells[i], options))
      result.tallies.push_back(std::move(tally));
    if (progress) progress(static_cast<int>(i) + 1, static_cast<int>(cells.size()));
  }
  return result;
}

bool misses_mark(const StabilityTally& tally) {
  return tally.share(StabilityOutcome::wrong_and_silent) >= kMostSilent ||
         tally.share(StabilityOutcome::right_but_refused) >= kMostRefused;
}

StabilityTally over_all_cells(const StabilityResult& result, std::size_t method) {
  StabilityTally all;
  all.method = method;
  for (const StabilityTally& t : result.tallies) {
    if (t.method != method) continue;
    const bool first = (all.first_silent < 0 && t.first_silent >= 0) ||
                       (all.first_silent < 0 && all.first_refused < 0 && t.first_refused >= 0);
    if (first)
      all.cell = t.cell, all.first_silent = t.first_silent, all.first_refused = t.first_refused;
    all.trials += t.trials;
    all.flips += t.flips;
    for (std::size_t i = 0; i < kNumOutcomes; ++i) all.count[i] += t.count[i];
    for (const auto& [what, times] : t.said) all.said[what] += times;
  }
  return all;
}

std::vector<StabilityTally> missing_marks(const StabilityMap& map, const StabilityResult& result) {
  std::vector<StabilityTally> missing;
  for (const StabilityTally& t : result.tallies)
    if (!map.mark_over_map && map.methods[t.method].ours && misses_mark(t)) missing.push_back(t);
  for (std::size_t m = 0; map.mark_over_map && m < map.methods.size(); ++m) {
    const StabilityTally all = over_all_cells(result, m);
    if (map.methods[m].ours && misses_mark(all)) missing.push_back(all);
  }
  return missing;
}

}  // namespace tagcal::study
