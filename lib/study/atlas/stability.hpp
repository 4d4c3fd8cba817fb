#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "study/method.hpp"
#include "tagcal/random.hpp"

// Maps of failure: one or two quantities are swept to where methods break, and what each method
// says is held against the truth.

namespace tagcal::study {

// What came of a method at one problem.
//
// Wrong, of a method that claims a covariance: the truth is outside of the ellipsoid that a normal
// variable of as many dimensions leaves as rarely as one of one dimension leaves 5 sigma
// (probability 5.7e-7). Of a method that claims none: its error is outside of that ellipsoid of the
// Cramer-Rao bound at the truth, or gross.
enum class StabilityOutcome {
  right_and_said,     // an answer, and the truth is where it says
  wrong_and_said,     // refused where nothing could be known; or another than its first is true
  wrong_and_silent,   // an answer, and none of what it says is true
  right_but_refused,  // refused what could be known
};
inline constexpr std::size_t kNumOutcomes = 4;
std::string_view outcome_name(StabilityOutcome outcome);  // as in the enum

struct StabilityVerdict {
  StabilityOutcome outcome = StabilityOutcome::wrong_and_said;
  // sqrt(e' F e / p), of corners their RMS over that of the bound; NaN: no answer
  double over_bound = std::numeric_limits<double>::quiet_NaN();
  bool flipped = false;  // nearer to the mirror image of the truth than to it: planes
  std::string said;      // its status, or "answer", "no answer"
};

// A quantity that is swept. Kinds are numbered from 0 and have names.
struct StabilityAxis {
  std::string quantity;            // "tilt"
  std::string unit;                // "deg"; empty: none
  std::vector<double> values;      // in that unit
  std::vector<std::string> names;  // of kinds, one a value; else empty

  std::string label(std::size_t i) const;  // "10", or the kind's name
};

struct StabilityMethod {
  std::string name;
  std::string settings;  // how it is called
  bool ours = false;     // runs all trials of a cell, and the mark is for it
  bool drawn = true;     // has a panel in the picture
};

// A drawn problem: makes it ready for a method of the map, by number.
using StabilityProblem = std::function<Prepared<StabilityVerdict>(std::size_t method)>;

struct StabilityMap {
  std::string name;   // as on the command line: "tag-tilt-distance"
  std::string title;  // for readers
  std::vector<StabilityAxis> axes;
  std::vector<StabilityMethod> methods;
  int trials = 3000;  // of a cell, of ours
  int peer_trials = 200;
  int quick_trials = 20;       // of all methods
  bool mark_over_map = false;  // the marks are for the whole map, not for each cell

  // Three sentences for the page: what happens, why (with the reference), what ours does about it.
  std::string what, why, answer;
  std::vector<std::string> exempt;  // what data of this kind cannot show, and the reason

  // A new problem of the cell with these values, one an axis. Called from several threads.
  std::function<StabilityProblem(std::span<const double> at, Random&)> draw;

  // The share of flips that theory expects of the likeliest answer; no value: it says nothing.
  std::function<std::optional<double>(std::span<const double> at)> expected_flips = {};

  std::size_t num_cells() const;
  std::vector<std::size_t> indices(std::size_t cell) const;  // one an axis; the last runs fastest
  std::vector<double> values(std::size_t cell) const;
  std::string cell_label(std::size_t cell) const;  // "tilt 10 deg, distance 2 m"
};

// Of poses, of calibrations, of tags in pictures, in the order of the page.
std::vector<StabilityMap> stability_maps();

// The map with our methods alone: the same problems, and numbers of trials, without the peers.
StabilityMap ours_alone(StabilityMap map);

struct StabilityOptions {
  std::uint64_t seed = 1;
  int threads = 1;     // 0: one a core. Nothing but times depends on it
  bool quick = false;  // few trials: all maps in about a minute
  int trials = 0;      // of a cell; peers stop at their own number. 0: what the map takes
  std::vector<std::size_t> cells = {};  // only these, ascending; empty: all
};

// All trials of one method in one cell.
struct StabilityTally {
  std::size_t cell = 0, method = 0;
  int trials = 0;
  std::array<int, kNumOutcomes> count = {};  // by StabilityOutcome
  int flips = 0;
  double rms_over_bound = 0;     // of the answers that are right; NaN: none
  double median_over_bound = 0;  // of all answers; NaN: none
  double time_us = 0;            // median, of the thread's processor
  std::map<std::string, int> said;
  int first_silent = -1, first_refused = -1;  // numbers of trials to look at; -1: none

  int of(StabilityOutcome outcome) const { return count[static_cast<std::size_t>(outcome)]; }
  double share(StabilityOutcome outcome) const {
    return trials > 0 ? static_cast<double>(of(outcome)) / trials : 0;
  }
};

struct StabilityResult {
  std::string map;
  std::uint64_t seed = 0;
  std::vector<StabilityTally> tallies;  // by cell and method
};

// Trial `t` of cell `c` is drawn from Random(seed, c << 32 | t), so that equal seeds give equal
// results whatever the threads and the number of trials. `progress(done, total)` counts cells.
// Throws Error for options that are out of range.
StabilityResult run_map(const StabilityMap& map, const StabilityOptions& options,
                        const std::function<void(int, int)>& progress = {});

// The marks: of ours, in each cell (of calibrations: over each map), wrong and silent in fewer than
// 1 of 1,000 trials, and refused in fewer than 2 of 100 what could be known.
inline constexpr double kMostSilent = 1e-3, kMostRefused = 0.02;
bool misses_mark(const StabilityTally& tally);

// All cells of a method as one; `cell` is that of the first silent trial, or of the first refused.
StabilityTally over_all_cells(const StabilityResult& result, std::size_t method);

// What misses: cells of ours; of a map whose marks are for the whole, ours that miss over it.
std::vector<StabilityTally> missing_marks(const StabilityMap& map, const StabilityResult& result);

// A map and what came of it.
struct AtlasSheet {
  StabilityMap map;
  StabilityResult result;
  bool has_picture = false;  // <name>.png beside the page
};

}  // namespace tagcal::study
