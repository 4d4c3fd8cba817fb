#include "report/history_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "job/terminal.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

using HistoryJson = nlohmann::ordered_json;

constexpr double kSuspicious = 0.01;  // p of a scatter that a sentence names

std::string pixels_text(const HistoryChange& change) {
  const Measured m = measured(change.px, change.sigma_px);
  return fmt::format("{} +- {} px", m.value, m.sigma.empty() ? "0" : m.sigma);
}

std::string sentence(const CameraHistory& history, const HistoryInput& input) {
  const HistoryFit &trend = history.trend, &step = history.step;
  const std::string place =
      fmt::format("between {} {:g} and {:g}", input.key, step.after, step.before);
  switch (history.verdict) {
    case HistoryVerdict::too_few:
      return fmt::format("{} are too few to tell noise from a change: give more{}",
                         counted(input.names.size(), "calibration"),
                         input.key == "order" ? "" : ", at different " + input.key);
    case HistoryVerdict::trend:
      return fmt::format(
          "the camera changes with {}, by {} in the image from {:g} to {:g} (p {:.1g})", input.key,
          pixels_text(trend.image), trend.after, trend.before, trend.p_value);
    case HistoryVerdict::change:
      return fmt::format("the camera changed {}, by {} in the image (p {:.1g})", place,
                         pixels_text(step.image), step.p_value);
    case HistoryVerdict::stable:
      break;
  }
  return fmt::format(
      "neither a trend with {} (p {:.2g}) nor a change (p {:.2g}); {:.0f} false alarm in 100 "
      "histories",
      input.key, trend.p_value, step.p_value, 100 * history.false_alarm);
}

std::string verdict_word(HistoryVerdict verdict) {
  switch (verdict) {
    case HistoryVerdict::stable:
      return toned(Tone::good, "STABLE");
    case HistoryVerdict::trend:
      return toned(Tone::bad, "TREND");
    case HistoryVerdict::change:
      return toned(Tone::bad, "CHANGE");
    case HistoryVerdict::too_few:
      break;
  }
  return toned(Tone::caution, "TOO FEW");
}

std::string fit_lines(const std::string& title, const HistoryFit& fit,
                      const std::string& image_title) {
  std::string text = fmt::format("{} (p {:.2g})\n", title, fit.p_value);
  for (const HistoryChange& change : fit.parameters)
    text += fmt::format("  {:<12} {}\n", change.name, pixels_text(change));
  return text + fmt::format("  {:<12} {} {}\n", "image", pixels_text(fit.image), image_title);
}

std::string scatter_line(const CameraHistory& history) {
  const bool is_step = history.verdict == HistoryVerdict::change;
  const HistoryFit& fit = is_step ? history.step : history.trend;
  if (!(fit.p_scatter < kSuspicious)) return "";
  return wrapped("! ",
                 fmt::format("about the {} the calibrations scatter {:.1f} times as much as their "
                             "covariances say (p {:.1g}); the standard deviations above include it",
                             is_step ? "step" : "line", fit.scatter, fit.p_scatter),
                 2);
}

HistoryJson fit_json(const HistoryFit& fit) {
  HistoryJson parameters = HistoryJson::array();
  for (const HistoryChange& change : fit.parameters)
    parameters.push_back({{"name", change.name}, {"px", change.px}, {"sigma_px", change.sigma_px}});
  return {{"p_value", fit.p_value}, {"from", fit.after},
          {"to", fit.before},       {"parameters", parameters},
          {"max_px", fit.image.px}, {"sigma_max_px", fit.image.sigma_px},
          {"scatter", fit.scatter}, {"p_scatter", fit.p_scatter}};
}

}  // namespace

std::string history_text(const CameraHistory& history, const HistoryInput& input) {
  std::string text = wrapped(verdict_word(history.verdict) + ": ", sentence(history, input), 2);
  if (history.verdict != HistoryVerdict::too_few) {
    text += fit_lines(input.key == "order" ? "a line, by calibration"
                                           : fmt::format("a line, by 1 of {}", input.key),
                      history.trend,
                      fmt::format("from {:g} to {:g}", history.trend.after, history.trend.before));
    text += fit_lines(
        fmt::format("one step between {:g} and {:g}", history.step.after, history.step.before),
        history.step, "at most");
    text += scatter_line(history);
  }
  text += fmt::format("largest displacement in the image from the first\n");
  for (std::size_t k = 0; k < input.names.size(); ++k)
    text += fmt::format("  {:>8.6g}  {:>8} px  {}\n", input.keys[k],
                        two_digits(input.displacements_px[k]), input.names[k]);
  return text;
}

HistoryJson history_json(const CameraHistory& history, const HistoryInput& input) {
  HistoryJson calibrations = HistoryJson::array();
  for (std::size_t k = 0; k < input.names.size(); ++k)
    calibrations.push_back({{"name", input.names[k]},
                            {"key", input.keys[k]},
                            {"displacement_px", input.displacements_px[k]}});
  const bool has_fits = history.verdict != HistoryVerdict::too_few;
  return {{"verdict", verdict_name(history.verdict)},
          {"false_alarm", history.false_alarm},
          {"key", input.key},
          {"trend", has_fits ? fit_json(history.trend) : HistoryJson()},
          {"change", has_fits ? fit_json(history.step) : HistoryJson()},
          {"calibrations", calibrations}};
}

std::string history_csv(const HistoryInput& input) {
  const Model* const model = input.cameras.front().model;
  std::string text = "name," + csv_field(input.key) + ",displacement_px";
  for (const FreeParameter& parameter : model->free())
    text += fmt::format(",{},sd_{}", parameter.name, parameter.name);
  text += "\n";
  for (std::size_t k = 0; k < input.names.size(); ++k) {
    const UncertainCamera& camera = input.cameras[k];
    text += fmt::format("{},{},{}", csv_field(input.names[k]), input.keys[k],
                        input.displacements_px[k]);
    const std::vector<double> values = model->free_values(camera.camera.lens);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      text += fmt::format(",{},{}", values[i], std::sqrt(camera.covariance(at, at)));
    }
    text += "\n";
  }
  return text;
}

}  // namespace tagcal::tools
