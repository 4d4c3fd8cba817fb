#include "study/chart/chart_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tagcal/io/text_file.hpp"

namespace tagcal::study {
namespace {

class Page {
 public:
  Page(const ChartResult& result, std::span<const ChartPoint> points)
      : result_(result), standings_(standings(result, points)) {}

  std::string text() const {
    return fmt::format(
               "# tagcal chart {}\n\n![speed against accuracy](chart.png)\n\n"
               "Time: median of the thread's processor time of one call. Error: RMS of the trials "
               "that did not fail, as a multiple of the {} (1.00); in [chart.csv](chart.csv) also "
               "as {}. Failed: {}. {} trials a panel, seed {}; every trial is in `trials.csv`.\n\n",
               result_.job, result_.bound_name, result_.error_unit, result_.failure,
               result_.num_trials, result_.seed) +
           against_peers() + off_front() + not_drawn() + settings() + origin();
  }

 private:
  const std::string& name_of(const ChartPoint& p) const {
    return result_.methods[static_cast<std::size_t>(p.method)].name;
  }
  std::string panel_of(const ChartPoint& p) const {
    return result_.panels[static_cast<std::size_t>(p.panel)].name();
  }
  static std::string share(const ChartPoint& p) {
    return fmt::format("{:.3g} %", 100 * p.failed_share());
  }

  // One row per panel with the first of our methods, which is the one for users.
  std::string against_peers() const {
    std::string text =
        "| panel | method | time, µs | error / bound | fails | fastest peer as accurate (5 %) | "
        "its "
        "time / ours | front |\n|---|---|--:|--:|--:|---|--:|---|\n";
    int panel = -1;
    for (const Standing& s : standings_) {
      if (s.ours.panel == panel) continue;
      panel = s.ours.panel;
      const std::string peer =
          s.fastest_equal ? fmt::format("{} ({:.2f}, fails {})", name_of(*s.fastest_equal),
                                        s.fastest_equal->rms_over_bound, share(*s.fastest_equal))
                          : "none";
      const std::string ratio =
          s.fastest_equal
              ? fmt::format("{:.2f}", s.fastest_equal->time_us.median / s.ours.time_us.median)
              : "";
      text += fmt::format("| {} | {} | {:.3g} | {:.3f} | {} | {} | {} | {} |\n", panel_of(s.ours),
                          name_of(s.ours), s.ours.time_us.median, s.ours.rms_over_bound,
                          share(s.ours), peer, ratio,
                          s.on_front   ? "yes"
                          : s.compared ? "no"
                                       : "not compared");
    }
    return text;
  }

  std::string off_front() const {
    std::string text = "\n## Where ours is not on the Pareto front\n\n";
    const std::size_t before = text.size();
    for (const Standing& s : standings_) {
      if (s.on_front) continue;
      if (!s.compared) {
        text += fmt::format(
            "- {}: {} fails in {} of the trials, {:.0f} points more than the most "
            "reliable method\n",
            panel_of(s.ours), name_of(s.ours), share(s.ours),
            100 * (s.ours.failed_share() - s.fewest_failures));
        continue;
      }
      const ChartPoint& peer = *s.dominated_by;
      text += fmt::format(
          "- {}: {} ({:.3g} µs, {:.3f} bounds, fails {}) is behind {} ({:.3g} µs, {:.3f} bounds, "
          "fails {}): {:.2f} times the time, {:.2f} times the error\n",
          panel_of(s.ours), name_of(s.ours), s.ours.time_us.median, s.ours.rms_over_bound,
          share(s.ours), name_of(peer), peer.time_us.median, peer.rms_over_bound, share(peer),
          s.ours.time_us.median / peer.time_us.median, s.ours.rms_over_bound / peer.rms_over_bound);
    }
    if (text.size() == before) text += "Nowhere: no peer is both faster and more accurate.\n";
    return text;
  }

  std::string not_drawn() const {
    std::map<std::string, int> reasons;
    for (const ChartPanel& panel : result_.panels)
      for (const std::string& why : panel.cannot) ++reasons[why];
    if (reasons.empty()) return "";
    std::string text = "\n## What is not drawn\n\n";
    for (const auto& [why, panels] : reasons)
      text += fmt::format("- {} ({} panel{})\n", why, panels, panels == 1 ? "" : "s");
    return text;
  }

  std::string settings() const {
    std::string text = "\n## Methods\n\n";
    for (const ChartMethod& m : result_.methods)
      text += fmt::format("- {}: {}\n", m.name, m.settings);
    return text;
  }

  std::string origin() const {
    std::string text = "\n## Origin\n\n";
    for (const std::string& line : result_.origin) text += fmt::format("- {}\n", line);
    return text;
  }

  const ChartResult& result_;
  std::vector<Standing> standings_;
};

constexpr std::string_view kFirstLine = "# tagcal chart: trials, version 1";
constexpr std::string_view kHeader = "panel,method,trial,time_us,error,error_over_bound";

}  // namespace

std::string chart_markdown(const ChartResult& result, std::span<const ChartPoint> points) {
  return Page(result, points).text();
}

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
