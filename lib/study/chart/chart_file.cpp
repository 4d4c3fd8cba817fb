#include "study/chart/chart_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tagcal/io/text_file.hpp"

namespace tagcal::study {
namespace {

constexpr std::string_view kFirstLine = "# tagcal chart: trials, version 1";
constexpr std::string_view kHeader = "panel,method,trial,time_us,error,error_over_bound";

}  // namespace

std::string trials_text(const ChartResult& result) {
  std::string text = fmt::format(
      "{}\n# job: {}\n# error: {}\n# bound: {}\n# failure: {}\n# seed: {}\n# quick: {}\n# trials: "
      "{}\n",
      kFirstLine, result.job, result.error_unit, result.bound_name, result.failure, result.seed,
      result.quick ? 1 : 0, result.num_trials);
  for (const std::string& line : result.origin) text += fmt::format("# origin: {}\n", line);
  for (const ChartMethod& m : result.methods)
    text += fmt::format("# method: {} | {} | {}\n", m.ours ? 1 : 0, m.name, m.settings);
  for (const ChartPanel& p : result.panels) {
    text += fmt::format("# panel: {} | {} | {}\n", p.page, p.row, p.column);
    for (const std::string& why : p.cannot) text += fmt::format("# cannot: {}\n", why);
  }
  text += fmt::format("{}\n", kHeader);
  for (const ChartTrial& t : result.trials) {
    text += fmt::format("{},{},{},{:.5g},", t.panel, t.method, t.trial, t.time_us);
    text += t.failed ? std::string(",\n") : fmt::format("{},{}\n", t.error, t.over_bound);
  }
  return text;
}

std::string points_csv(const ChartResult& result, std::span<const ChartPoint> points) {
  std::string text = "job,method,panel,time_us,rms,rms_over_bound,failures,trials\n";
  const auto number = [](double v) { return std::isfinite(v) ? fmt::format("{:.6g}", v) : ""; };
  for (const ChartPoint& p : points)
    text += fmt::format("{},{},{},{:.4g},{},{},{},{}\n", result.job,
                        csv_field(result.methods[static_cast<std::size_t>(p.method)].name),
                        csv_field(result.panels[static_cast<std::size_t>(p.panel)].name()),
                        p.time_us.median, number(p.rms), number(p.rms_over_bound), p.failures,
                        p.trials);
  return text;
}

}  // namespace tagcal::study
