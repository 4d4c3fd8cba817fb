#include "calibration_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <string_view>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "uncertainty_picture.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  // null in JSON
constexpr std::size_t kOutliersShown = 10;

// A parameter as it may be shown: NaN where there is no answer for it.
struct Shown {
  std::string_view name;
  double value = kUnknown;
  double sigma = kUnknown;  // 0: held
};

bool is_free(const Model& model, int lens_parameter) {
  return std::any_of(model.free().begin(), model.free().end(), [&](const FreeParameter& free) {
    const auto& of = free.lens_parameters;
    return std::find(of.begin(), of.end(), lens_parameter) != of.end();
  });
}

// Where the solver stood without an answer is not shown: it would look like one.
std::vector<Shown> shown_parameters(const Calibration& calibration) {
  const Lens& lens = calibration.camera->lens;
  const std::span<const double> values = parameters(lens);
  const Model& model = Model::named(calibration.model);
  const bool parallel = std::holds_alternative<Parallel>(lens);
  std::vector<Shown> shown;
  for (std::size_t i = 0; i < values.size(); ++i) {
    Shown parameter;
    const bool free = is_free(model, static_cast<int>(i));
    const bool scale_of_a_view = parallel && i < 2;  // sx, sy: every view has its own
    parameter.name = scale_of_a_view ? Perspective::kParameterNames[i] : parameter_names(lens)[i];
    if (!scale_of_a_view && (!free || is_answer(calibration.status))) {
      parameter.value = values[i];
      if (i < calibration.sigmas.size()) parameter.sigma = calibration.sigmas[i];
      if (!free) parameter.sigma = 0;
    }
    shown.push_back(parameter);
  }
  return shown;
}

// OpenCV's vector of coefficients: five, eight for the rational model, four for the fisheye.
std::size_t num_shown(const Calibration& calibration) {
  const std::size_t all = parameters(calibration.camera->lens).size();
  const bool perspective = std::holds_alternative<Perspective>(calibration.camera->lens);
  return perspective && calibration.model != "opencv8" ? all - 3 : all;
}

// null as a whole where one of the coefficients is not known.
Json distortion_json(std::span<const Shown> coefficients, double Shown::*member) {
  Json list = Json::array();
  for (const Shown& coefficient : coefficients) {
    if (!std::isfinite(coefficient.*member)) return nullptr;
    list.push_back(coefficient.*member);
  }
  return list;
}

Json camera_json(const Calibration& calibration, double Shown::*member) {
  if (!calibration.camera) return nullptr;
  const std::vector<Shown> all = shown_parameters(calibration);
  const std::span<const Shown> shown(all.data(), num_shown(calibration));
  return {{"fx", shown[0].*member},
          {"fy", shown[1].*member},
          {"cx", shown[2].*member},
          {"cy", shown[3].*member},
          {"distortion", distortion_json(shown.subspan(4), member)}};
}

std::string parameter_line(const Shown& p) {
  if (!std::isfinite(p.value)) return fmt::format("  {:<4} {:>14}\n", p.name, "not known");
  std::string text = fmt::format("  {:<4} {:>14.6f}", p.name, p.value);
  if (p.sigma == 0) return text + "    held\n";
  return text + (std::isfinite(p.sigma) ? fmt::format(" +- {:.6f}\n", p.sigma) : " +- not known\n");
}

std::string outlier_lines(std::vector<Outlier> outliers) {
  if (outliers.empty()) return "outliers   none\n";
  const auto badness = [](const Outlier& o) {  // one that does not project at all is the worst
    return std::isnan(o.residual_px) ? std::numeric_limits<double>::infinity() : o.residual_px;
  };
  std::stable_sort(outliers.begin(), outliers.end(),
                   [&](const Outlier& a, const Outlier& b) { return badness(a) > badness(b); });
  std::string text = fmt::format("outliers   {}\n", outliers.size());
  for (std::size_t i = 0; i < std::min(outliers.size(), kOutliersShown); ++i) {
    const Outlier& o = outliers[i];
    const std::string residual =
        std::isnan(o.residual_px) ? "does not project" : fmt::format("{:.2f} px", o.residual_px);
    text += fmt::format("  {} tag {} corner {}: {}\n", o.image, o.id.tag_id, o.id.corner, residual);
  }
  if (outliers.size() > kOutliersShown) {
    text += fmt::format("  and {} more\n", outliers.size() - kOutliersShown);
  }
  return text;
}

double largest(const ProjectionUncertainty& p) {
  double value = 0;
  for (const double sigma : p.sigma_px.reshaped()) value = sigma > value ? sigma : value;
  return value;
}

Json projection_json(const Calibration& calibration) {
  Json list = Json::array();
  for (const ProjectionUncertainty& p : calibration.projection) {
    const bool far = !std::isfinite(p.distance_m);
    list.push_back({{"distance_m", far ? Json("infinity") : Json(p.distance_m)},
                    {"rms_px", p.region_px},
                    {"max_px", p.region_max_px},
                    {"centre_px", p.sigma_px(p.grid.rows / 2, p.grid.columns / 2)},
                    {"whole_image_max_px", largest(p)}});
  }
  return list;
}

std::string projection_text(const Calibration& calibration) {
  std::string text;
  for (const ProjectionUncertainty& p : calibration.projection)
    text += fmt::format(
        "projection {:.3f} px at {} where corners were, {:.3f} px in the centre, {:.3f} px at "
        "worst over the image\n",
        p.region_px, distance_text(p.distance_m), p.sigma_px(p.grid.rows / 2, p.grid.columns / 2),
        largest(p));
  if (!calibration.projection.empty())
    text += fmt::format("seen       {:.0f} % of the image lies among the corners\n",
                        100 * calibration.seen.share());
  if (const auto& warp = calibration.board_warp)
    text +=
        fmt::format("board      bent by {:.3f} +- {:.3f} mm along x, {:.3f} +- {:.3f} mm along y\n",
                    warp->bend_mm.x(), warp->sigma_mm.x(), warp->bend_mm.y(), warp->sigma_mm.y());
  if (calibration.halves)
    text += fmt::format("halves     differ by {:.2f} of what their noise predicts\n",
                        calibration.halves->ratio);
  return text;
}

Json halves_json(const std::optional<HalvesCheck>& halves) {
  if (!halves) return nullptr;
  return {{"difference_px", halves->difference_px},
          {"predicted_px", halves->predicted_px},
          {"ratio", halves->ratio},
          {"disagree", halves->disagree}};
}

Json warp_json(const std::optional<BoardWarp>& warp) {
  if (!warp) return nullptr;
  return {{"bend_mm", {warp->bend_mm.x(), warp->bend_mm.y()}},
          {"sigma_mm", {warp->sigma_mm.x(), warp->sigma_mm.y()}}};
}

Json weak_directions_json(const Calibration& calibration) {
  Json list = Json::array();
  for (const WeakDirection& weak : calibration.weak_directions)
    list.push_back(
        {{"parameter", weak.parameter}, {"sigma_px", weak.sigma_px}, {"sentence", weak.sentence}});
  return list;
}

Json advice_json(const std::optional<AdvisedView>& advice) {
  if (!advice) return nullptr;
  constexpr double kDegree = std::numbers::pi / 180;
  return {{"tilt_deg", advice->tilt_rad / kDegree},
          {"distance_m", advice->distance_m},
          {"pixel", {advice->pixel.x(), advice->pixel.y()}},
          {"focal_sigma_now_px", advice->focal_sigma_now_px},
          {"focal_sigma_px", advice->focal_sigma_px},
          {"projection_px", advice->projection_px},
          {"sentence", advice->sentence}};
}

Json outliers_json(const std::vector<Outlier>& outliers) {
  Json list = Json::array();
  for (const Outlier& o : outliers)
    list.push_back({{"image", o.image},
                    {"tag_id", o.id.tag_id},
                    {"corner", o.id.corner},
                    {"residual_px", o.residual_px}});
  return list;
}

Json steps_json(const std::vector<ModelStep>& steps) {
  Json list = Json::array();
  for (const ModelStep& step : steps) {
    list.push_back({{"model", step.model},
                    {"parameters", step.num_parameters},
                    {"cost", step.cost},
                    {"bic", step.bic},
                    {"difference_px", step.difference_px ? Json(*step.difference_px) : Json()},
                    {"taken", step.taken},
                    {"sentence", step.sentence}});
  }
  return list;
}

std::string steps_text(const std::vector<ModelStep>& steps) {
  std::string text = steps.empty() ? "" : "ladder\n";
  for (const ModelStep& step : steps) {
    text += fmt::format("  {} {:<9} {}\n", step.taken ? '+' : '-', step.model, step.sentence);
  }
  return text;
}

}  // namespace

std::string calibration_json(const Calibration& calibration, const CommandSeconds& seconds,
                             const std::optional<AdvisedView>& advice) {
  const bool known = calibration.camera.has_value();
  const CalibrateSeconds& spent = calibration.seconds;
  const Json answer = {{"status", status_name(calibration.status)},
                       {"model", calibration.model.empty() ? Json() : Json(calibration.model)},
                       {"camera", camera_json(calibration, &Shown::value)},
                       {"sigma", camera_json(calibration, &Shown::sigma)},
                       {"rms_px", known ? Json(calibration.rms_px) : Json()},
                       {"sigma_px", known ? Json(calibration.sigma_px) : Json()},
                       {"num_views", calibration.views.size()},
                       {"num_corners", calibration.num_corners},
                       {"num_outliers", calibration.outliers.size()},
                       {"outliers", outliers_json(calibration.outliers)},
                       {"projection", projection_json(calibration)},
                       {"seen_share", known ? Json(calibration.seen.share()) : Json()},
                       {"halves", halves_json(calibration.halves)},
                       {"board_warp", warp_json(calibration.board_warp)},
                       {"weak_directions", weak_directions_json(calibration)},
                       {"advice", advice_json(advice)},
                       {"steps", steps_json(calibration.steps)},
                       {"warnings", calibration.warnings},
                       {"seconds",
                        {{"read", seconds.read},
                         {"start", spent.start},
                         {"solve", spent.solve},
                         {"covariance", spent.covariance},
                         {"total", seconds.total}}}};
  return answer.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string_view noise_source(const Calibration& calibration) {
  if (calibration.sigma_of_corners) return "in units of each corner's own";
  return calibration.sigma_from_residuals ? "from the residuals" : "as stated";
}

std::string advice_text(const std::optional<AdvisedView>& advice, bool asked) {
  if (!asked) return "";
  return "next view  " + (advice ? advice->sentence : "none of the views tried would help") + "\n";
}

std::string calibration_summary(const Calibration& calibration, const CommandSeconds& seconds,
                                bool chosen) {
  std::string text = fmt::format("status     {}\n", status_name(calibration.status));
  if (calibration.camera) {
    text += fmt::format("model      {}{}\n", calibration.model,
                        chosen ? " (chosen, see the ladder)" : "");
    const std::vector<Shown> shown = shown_parameters(calibration);
    for (std::size_t i = 0; i < num_shown(calibration); ++i) text += parameter_line(shown[i]);
    text += fmt::format("rms        {:.4f} px over {} corners in {} views\n", calibration.rms_px,
                        calibration.num_corners, calibration.views.size());
    text += fmt::format("noise      {:.4f} px per coordinate ({})\n", calibration.sigma_px,
                        noise_source(calibration));
  }
  text += projection_text(calibration);
  text += steps_text(calibration.steps) + outlier_lines(calibration.outliers);
  for (const std::string& warning : calibration.warnings) text += "warning: " + warning + "\n";
  text +=
      fmt::format("time       read {:.2f} s, start {:.2f} s, solve {:.2f} s, covariance {:.2f} s\n",
                  seconds.read, calibration.seconds.start, calibration.seconds.solve,
                  calibration.seconds.covariance);
  return text;
}

}  // namespace tagcal::tools
