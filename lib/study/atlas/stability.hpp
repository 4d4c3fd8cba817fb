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

// Maps of failure: one or two quantities are varied until the methods fail, and the answer of each
// method is compared with the truth.

namespace tagcal::study {

// The outcome of a method for one problem.
//
// The answer of a method that claims a covariance is wrong if the truth is outside of its ellipsoid
// of probability 1 - 5.7e-7, the probability of 5 sigma in one dimension. The answer of a method
// without a covariance is wrong if its error is outside of that ellipsoid of the Cramer-Rao bound
// at the truth, or gross.
enum class StabilityOutcome {
  right_and_said,     // a correct answer
  wrong_and_said,     // a refusal of a problem that cannot be solved; or an alternative is correct
  wrong_and_silent,   // an answer, and none of its alternatives is correct
  right_but_refused,  // a refusal of a problem that can be solved
};
inline constexpr std::size_t kNumOutcomes = 4;
std::string_view outcome_name(StabilityOutcome outcome);  // as in the enum

struct StabilityVerdict {
  StabilityOutcome outcome = StabilityOutcome::wrong_and_said;
  // sqrt(e' F e / p); for corners, their RMS error over that of the bound; NaN: no answer
  double over_bound = std::numeric_limits<double>::quiet_NaN();
  bool flipped = false;  // planes: nearer to the flipped truth than to the truth
  std::string said;      // its status, or "answer", "no answer"
};

// A quantity that varies. The values of a nominal one are 0, 1, .. and have names.
struct StabilityAxis {
  std::string quantity;            // "tilt"
  std::string unit;                // "deg"; empty: none
  std::vector<double> values;      // in that unit
  std::vector<std::string> names;  // of nominal values; else empty

  std::string label(std::size_t i) const;  // "10", or the name
};

struct StabilityMethod {
  std::string name;
  std::string settings;  // how it is called
  bool ours = false;     // runs all trials of a cell, and the mark is for it
  bool drawn = true;     // has a panel in the picture
};

// Prepares a drawn problem for a method of the map, by number.
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

  // Three sentences for the page: the failure, its reason (with a reference), and our remedy.
  std::string what, why, answer;
  std::vector<std::string> exempt;  // what data of this kind cannot show, and the reason

  // Draws a problem of the cell with these values, one per axis. Called from several threads.
  std::function<StabilityProblem(std::span<const double> at, Random&)> draw;

  // The expected share of flips of the likeliest answer; no value if theory does not give one.
  std::function<std::optional<double>(std::span<const double> at)> expected_flips = {};

  std::size_t num_cells() const;
  std::vector<std::size_t> indices(std::size_t cell) const;  // one an axis; the last runs fastest
  std::vector<double> values(std::size_t cell) const;
  std::string cell_label(std::size_t cell) const;  // "tilt 10 deg, distance 2 m"
};

// The maps of poses, of calibrations and of tags in pictures, in the order of the page.
std::vector<StabilityMap> stability_maps();

// The map without the peers, with the same problems and numbers of trials.
StabilityMap ours_alone(StabilityMap map);

struct StabilityOptions {
  std::uint64_t seed = 1;
  int threads = 1;     // 0: one per core. Only times depend on it
  bool quick = false;  // few trials: all maps in about a minute
  int trials = 0;      // per cell; peers stop at their own number. 0: the number of the map
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
  int first_silent = -1, first_refused = -1;  // trial numbers; -1: none

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
// results for any number of threads and trials. `progress(done, total)` counts cells.
// Throws Error for options that are out of range.
StabilityResult run_map(const StabilityMap& map, const StabilityOptions& options,
                        const std::function<void(int, int)>& progress = {});

// The marks of our methods, in each cell (for calibrations: over each map): wrong and silent in
// fewer than 1 of 1,000 trials, and right but refused in fewer than 2 of 100.
inline constexpr double kMostSilent = 1e-3, kMostRefused = 0.02;
bool misses_mark(const StabilityTally& tally);

// The sum over all cells of a method; `cell` is that of the first silent trial, or of the first
// refused one.
StabilityTally over_all_cells(const StabilityResult& result, std::size_t method);

// The cells in which our methods miss the marks; for a map with mark_over_map, the methods that
// miss them over the whole map.
std::vector<StabilityTally> missing_marks(const StabilityMap& map, const StabilityResult& result);

// A map and its result; <name>.png stands beside the page.
struct AtlasSheet {
  StabilityMap map;
  StabilityResult result;
};

}  // namespace tagcal::study
