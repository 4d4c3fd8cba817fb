#include "study/atlas/stability_file.hpp"

#include <fmt/format.h>

#include <cmath>

namespace tagcal::study {
namespace {

std::string field(const std::string& text) {
  return text.find(',') == std::string::npos ? text : fmt::format("\"{}\"", text);
}

std::string number(double v) { return std::isfinite(v) ? fmt::format("{:.6g}", v) : ""; }

std::string trial(int t) { return t < 0 ? "" : fmt::format("{}", t); }

std::string statements(const StabilityTally& tally) {
  std::string text;
  for (const auto& [what, times] : tally.said)
    text += fmt::format("{}{}:{}", text.empty() ? "" : " ", what, times);
  return text;
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
    text += fmt::format("{},{},{},{},{}", map.name, field(map.axes[0].label(at[0])),
                        at.size() > 1 ? field(map.axes[1].label(at[1])) : "",
                        field(map.methods[tally.method].name), tally.trials);
    for (const int n : tally.count) text += fmt::format(",{}", n);
    text += fmt::format(",{},{},{},{:.4g},{},{},{}\n", number(tally.rms_over_bound),
                        number(tally.median_over_bound), tally.flips, tally.time_us,
                        statements(tally), trial(tally.first_silent), trial(tally.first_refused));
  }
  return text;
}

}  // namespace tagcal::study
