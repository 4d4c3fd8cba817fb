#include "report/calibration_report.hpp"
#include "report/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "draw/uncertainty_picture.hpp"
#include "report/dropped_corners.hpp"
#include "report/shown_parameters.hpp"

namespace tagcal::tools {
namespace {

std::string parameter_line(const Shown& p) {
  if (!std::isfinite(p.value)) return fmt::format("  {:<4} {:>14}\n", p.name, "not known");
  std::string text = fmt::format("  {:<4} {:>14.6f}", p.name, p.value);
  if (p.sigma == 0) return text + "    held\n";
  return text + (std::isfinite(p.sigma) ? fmt::format(" +- {:.6f}\n", p.sigma) : " +- not known\n");
}

std::string fixed_text(const std::map<std::string, double>& fixed) {
  std::string text;
  for (const auto& [name, value] : fixed)
    text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", name, value);
  return text.empty() ? "" : fmt::format("fixed      {}: held as asked, taken as exact\n", text);
}

// The scales of the views, which model weak has instead of a focal length.
std::string scales_text(const Calibration& calibration) {
  std::vector<double> scales;
  for (const CalibratedView& view : calibration.views)
    if (view.scale_px_per_m) scales.push_back(*view.scale_px_per_m);
  if (scales.empty()) return "";
  const auto [least, most] = std::minmax_element(scales.begin(), scales.end());
  return fmt::format("scale      {:.3f} to {:.3f} px/m, each view its own (--json lists them)\n",
                     *least, *most);
}

std::string pixels_text(double sigma_px, const ImageSize& size) {
  return has_bound(sigma_px, size) ? fmt::format("{:.3f} px", sigma_px) : "no bound";
}

std::string projection_line(const ProjectionUncertainty& p) {
  const ImageSize& size = p.grid.size;
  const int without_ray = nodes_without_ray(p);
  return fmt::format(
      "projection sd {} at {} where corners were, {} in the centre, {} at most over "
      "the image{}\n",
      pixels_text(p.region_px, size), distance_text(p.distance_m),
      pixels_text(p.sigma_px(p.grid.rows / 2, p.grid.columns / 2), size),
      pixels_text(largest_px(p), size),
      without_ray == 0
          ? ""
          : fmt::format(", no ray at {} of {} nodes", without_ray, p.grid.rows * p.grid.columns));
}

std::string projection_text(const Calibration& calibration) {
  std::string text;
  for (const ProjectionUncertainty& p : calibration.projection) text += projection_line(p);
  if (!calibration.projection.empty())
    text += fmt::format("seen       {:.0f} % of the image is inside the hull of the corners\n",
                        100 * calibration.seen.share());
  if (const auto& warp = calibration.board_warp)
    text +=
        fmt::format("board      bent by {:.3f} +- {:.3f} mm along x, {:.3f} +- {:.3f} mm along y\n",
                    warp->bend_mm.x(), warp->sigma_mm.x(), warp->bend_mm.y(), warp->sigma_mm.y());
  if (calibration.halves)
    text += fmt::format(
        "halves     two halves of the views {} (difference {:.2f} of the expected noise)\n",
        calibration.halves->disagree ? "disagree" : "agree", calibration.halves->ratio);
  return text;
}

std::string steps_text(const std::vector<ModelStep>& steps) {
  std::string text = steps.empty() ? "" : "ladder\n";
  for (const ModelStep& step : steps) {
    text += fmt::format("  {} {:<9} {}\n", step.taken ? '+' : '-', step.model, step.sentence);
  }
  return text;
}

std::string_view noise_source(const Calibration& calibration) {
  return calibration.sigma_from_residuals ? "from the residuals" : "as stated";
}

std::string noise_text(const Calibration& calibration) {
  if (!calibration.sigma_of_corners)
    return fmt::format("{:.4f} px per coordinate ({})", calibration.sigma_px,
                       noise_source(calibration));
  if (calibration.model_error_px == 0)
    return "each corner's own covariance, which explains the residuals";
  return fmt::format(
      "each corner's own covariance, and {:.4f} px per coordinate for errors of lens and target",
      calibration.model_error_px);
}

// "selected   5 views, one after the other .." and a line for each.
std::string selection_text(const std::optional<ViewSelection>& selection) {
  if (!selection) return "";
  std::string text = fmt::format(
      "selected   {} views; the projection's sd at infinity (RMS over the image) after each:\n",
      selection->views.size());
  double before = std::numeric_limits<double>::infinity();
  for (const SelectedView& view : selection->views) {
    const double now = view.projection_px;
    const std::string by =
        std::isfinite(before) ? fmt::format(", {:.1f} % less", 100 * (1 - now / before)) : "";
    text += fmt::format("  {}: {} corners, {}\n", view.image, view.num_corners,
                        std::isfinite(now) ? fmt::format("sd {:.4f} px{}", now, by)
                                           : std::string("not all parameters are determined yet"));
    before = now;
  }
  return text + fmt::format("  all views: sd {:.4f} px\n", selection->all_px);
}

}  // namespace

std::string advice_sentence(const std::optional<AdvisedView>& advice) {
  return advice ? advice->sentence : "none of the views tried would improve the answer";
}

std::string calibration_summary(const CalibrationAnswer& answer, bool chosen) {
  const Calibration& calibration = answer.calibration;
  std::string text = fmt::format("status     {}\n", status_name(calibration.status));
  if (calibration.camera) {
    text += fmt::format("model      {}{}\n", calibration.model,
                        chosen ? " (chosen, see the ladder)" : "");
    const std::vector<Shown> shown = shown_parameters(calibration);
    for (std::size_t i = 0; i < num_shown(calibration); ++i) text += parameter_line(shown[i]);
    text += fixed_text(calibration.fixed);
    text += fmt::format("rms        {:.4f} px over {} corners in {} views\n", calibration.rms_px,
                        calibration.num_corners, calibration.views.size());
    text += fmt::format("noise      {}\n", noise_text(calibration));
  }
  text += scales_text(calibration) + projection_text(calibration);
  text += steps_text(calibration.steps) + dropped_corners_text(calibration);
  text += selection_text(answer.selection);
  text += findings_text(calibration.findings);
  text +=
      fmt::format("time       read {:.2f} s, start {:.2f} s, solve {:.2f} s, covariance {:.2f} s\n",
                  answer.seconds.read, calibration.seconds.start, calibration.seconds.solve,
                  calibration.seconds.covariance);
  return text;
}

}  // namespace tagcal::tools
