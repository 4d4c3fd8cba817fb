#include "study/atlas/stability_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "study/harness/csv.hpp"
#include "tagcal/error.hpp"

namespace tagcal::study {
namespace {

std::string number(double v) { return std::isfinite(v) ? fmt::format("{:.6g}", v) : ""; }

std::string trial(int t) { return t < 0 ? "" : fmt::format("{}", t); }

std::string statements(const StabilityTally& tally) {
  std::string text;
  for (const auto& [what, times] : tally.said)
    text += fmt::format("{}{}:{}", text.empty() ? "" : " ", what, times);
  return text;
}

double number_of(const std::string& text) { return text.empty() ? std::nan("") : std::stod(text); }

int trial_of(const std::string& text) { return text.empty() ? -1 : std::stoi(text); }

// Statements may have spaces: "no answer:3 ok:2".
std::map<std::string, int> said_of(const std::string& text) {
  std::map<std::string, int> said;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t colon = text.find(':', at),
                      end = std::min(text.find(' ', colon), text.size());
    said[text.substr(at, colon - at)] = std::stoi(text.substr(colon + 1, end - colon - 1));
    at = end + 1;
  }
  return said;
}

}  // namespace

std::string stability_csv(const StabilityMap& map, const StabilityResult& result) {
  std::string text = "map,x,y,method,trials";
  for (std::size_t i = 0; i < kNumOutcomes; ++i)
    text += fmt::format(",{}", outcome_name(static_cast<StabilityOutcome>(i)));
  text +=
      ",rms_over_bound,median_over_bound,flips,time_us,said,first_silent,"
      "first_refused\n";
  for (const StabilityTally& tally : result.tallies) {
    const std::vector<std::size_t> at = map.indices(tally.cell);
    text += fmt::format("{},{},{},{},{}", map.name, csv_field(map.axes[0].label(at[0])),
                        at.size() > 1 ? csv_field(map.axes[1].label(at[1])) : "",
                        csv_field(map.methods[tally.method].name), tally.trials);
    for (const int n : tally.count) text += fmt::format(",{}", n);
    text += fmt::format(",{},{},{},{:.4g},{},{},{}\n", number(tally.rms_over_bound),
                        number(tally.median_over_bound), tally.flips, tally.time_us,
                        statements(tally), trial(tally.first_silent), trial(tally.first_refused));
  }
  return text;
}

StabilityResult read_stability(const StabilityMap& map, const std::string& text) {
  StabilityResult result{map.name, 0, {}};
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    const std::size_t i = result.tallies.size(), n = map.methods.size();
    const std::vector<std::string> cells = csv_cells(line);
    if (cells.size() != 9 + kNumOutcomes + 3 || i >= n * map.num_cells() ||
        cells[3] != map.methods[i % n].name)
      throw Error(fmt::format("{}.csv: line {} is not of this map", map.name, i + 2));
    StabilityTally tally;
    tally.cell = i / n, tally.method = i % n;
    tally.trials = static_cast<int>(number_of(cells[4]));
    for (std::size_t k = 0; k < kNumOutcomes; ++k)
      tally.count[k] = static_cast<int>(number_of(cells[5 + k]));
    tally.rms_over_bound = number_of(cells[9]);
    tally.median_over_bound = number_of(cells[10]);
    tally.flips = static_cast<int>(number_of(cells[11]));
    tally.time_us = number_of(cells[12]);
    tally.said = said_of(cells[13]);
    tally.first_silent = trial_of(cells[14]);
    tally.first_refused = trial_of(cells[15]);
    result.tallies.push_back(std::move(tally));
  }
  if (result.tallies.size() != map.methods.size() * map.num_cells())
    throw Error(map.name + ".csv: is not complete");
  return result;
}

}  // namespace tagcal::study
