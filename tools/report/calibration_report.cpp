#include "report/calibration_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "draw/heat_map.hpp"
#include "job/shown_parameters.hpp"
#include "job/terminal.hpp"
#include "report/findings.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal::tools {
namespace {

// "opencv4 (chosen), 12 pictures, 1728 corners, rms 0.21 px"
std::string extent_of(const Calibration& calibration, bool chosen) {
  const std::string model = (calibration.model.empty() ? "camera" : calibration.model) +
                            std::string(chosen ? " (chosen)" : "");
  if (calibration.num_corners == 0) return model;
  return fmt::format("{}, {}, {}, rms {} px", model, counted(calibration.views.size(), "picture"),
                     counted(static_cast<std::size_t>(calibration.num_corners), "corner"),
                     two_digits(calibration.rms_px));
}

// "fx    902.496 +- 0.012"
std::string parameter_text(const Shown& p) {
  if (!std::isfinite(p.value)) return fmt::format("  {:<3} {:>11}", p.name, "not known");
  const Measured m = measured(p.value, p.sigma);
  if (p.sigma == 0) return fmt::format("  {:<3} {:>11}    held", p.name, m.value);
  return fmt::format("  {:<3} {:>11} +- {}", p.name, m.value,
                     m.sigma.empty() ? "not known" : m.sigma);
}

// Focal lengths and principal point on the left, distortion on the right.
std::string camera_table(const Calibration& calibration) {
  const std::vector<Shown> shown = shown_parameters(calibration);
  const std::size_t left = std::min<std::size_t>(4, shown.size());
  std::vector<Shown> right(shown.begin() + left, shown.begin() + num_shown(calibration));
  // A model without distortion does not list its zeros.
  if (std::ranges::all_of(right, [](const Shown& p) { return p.sigma == 0 && p.value == 0; }))
    right.clear();
  std::string text;
  for (std::size_t i = 0; i < std::max(left, right.size()); ++i) {
    const std::string row = i < left ? parameter_text(shown[i]) : "";
    text +=
        i < right.size() ? fmt::format("{:<34}{}\n", row, parameter_text(right[i])) : row + "\n";
  }
  return text;
}

std::string fixed_text(const std::map<std::string, double>& fixed) {
  std::string text;
  for (const auto& [name, value] : fixed)
    text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", name, value);
  return text.empty() ? "" : fmt::format("held       {}, as asked; taken as exact\n", text);
}

// The scales of the views, which model weak has instead of a focal length.
std::string scales_text(const Calibration& calibration) {
  std::vector<double> scales;
  for (const CalibratedView& view : calibration.views)
    if (view.scale_px_per_m) scales.push_back(*view.scale_px_per_m);
  if (scales.empty()) return "";
  const auto [least, most] = std::minmax_element(scales.begin(), scales.end());
  if (scales.size() == 1) return fmt::format("scale      {:.3f} px/m\n", *least);
  return fmt::format("scale      {:.3f} to {:.3f} px/m, each view its own (--json lists them)\n",
                     *least, *most);
}

std::string pixels_text(double sigma_px, const ImageSize& size) {
  return has_bound(sigma_px, size) ? two_digits(sigma_px) + " px" : "no bound";
}

std::string projection_line(const ProjectionUncertainty& p) {
  const ImageSize& size = p.grid.size;
  const int without_ray = nodes_without_ray(p);
  return fmt::format("{} where corners were, {} in the centre, {} at most{} (sd at {})",
                     pixels_text(p.region_px, size),
                     pixels_text(p.sigma_px(p.grid.rows / 2, p.grid.columns / 2), size),
                     pixels_text(largest_px(p), size),
                     without_ray == 0 ? ""
                                      : fmt::format(", no ray at {} of {} nodes", without_ray,
                                                    p.grid.rows * p.grid.columns),
                     distance_text(p.distance_m));
}

// Standard deviations beyond which a term of the board is worth a line.
constexpr double kShownSigmas = 2;

bool is_significant(double value, double sigma) { return std::abs(value) > kShownSigmas * sigma; }

bool is_significant(const BoardWarp& warp) {
  return is_significant(warp.bend_mm.x(), warp.sigma_mm.x()) ||
         is_significant(warp.bend_mm.y(), warp.sigma_mm.y()) ||
         is_significant(warp.twist_mm, warp.sigma_twist_mm) ||
         is_significant(warp.aspect, warp.sigma_aspect);
}

// "0.89 +- 0.11 mm"
std::string term_text(double value, double sigma, std::string_view unit) {
  const Measured term = measured(value, sigma);
  return fmt::format("{} +- {} {}", term.value, term.sigma, unit);
}

// How the board differs from its file.
std::string board_text(const BoardWarp& warp) {
  return wrapped("board      ",
                 fmt::format("bent by {} along x, {} along y, twisted by {}, longer along y by {}",
                             term_text(warp.bend_mm.x(), warp.sigma_mm.x(), "mm"),
                             term_text(warp.bend_mm.y(), warp.sigma_mm.y(), "mm"),
                             term_text(warp.twist_mm, warp.sigma_twist_mm, "mm"),
                             term_text(100 * warp.aspect, 100 * warp.sigma_aspect, "%")),
                 11);
}

// How well a pixel is known: at infinity, or at every distance.
std::string projection_text(const Calibration& calibration, const SummaryOptions& options) {
  std::string text;
  for (const ProjectionUncertainty& p : calibration.projection) {
    if (!options.verbose && !text.empty()) break;
    text += wrapped(text.empty() ? "accuracy   " : std::string(11, ' '), projection_line(p), 11);
  }
  if (!calibration.projection.empty())
    text += fmt::format("coverage   {:.0f} % of the image is inside the hull of the corners\n",
                        100 * calibration.seen.share());
  const auto& warp = calibration.board_warp;
  if (warp && (options.board || is_significant(*warp))) text += board_text(*warp);
  if (calibration.readout) text += wrapped("readout    ", readout_text(*calibration.readout), 11);
  if (options.verbose && calibration.halves)
    text +=
        fmt::format("halves     {} {} (difference {:.2f} of the expected noise)\n",
                    halves_text(*calibration.halves),
                    calibration.halves->disagree ? "disagree" : "agree", calibration.halves->ratio);
  return text;
}

std::string steps_text(const std::vector<ModelStep>& steps) {
  std::string text = steps.empty() ? "" : "ladder\n";
  for (const ModelStep& step : steps) {
    text +=
        wrapped(fmt::format("  {} {:<9} ", step.taken ? '+' : '-', step.model), step.sentence, 14);
  }
  return text;
}

// The pictures with the largest residuals, by name: those to look at first.
std::string worst_pictures_text(const Calibration& calibration) {
  constexpr std::size_t kShown = 3;
  std::vector<const CalibratedView*> views;
  for (const CalibratedView& view : calibration.views) views.push_back(&view);
  if (views.size() < 2) return "";
  std::ranges::stable_sort(views, std::ranges::greater(), &CalibratedView::rms_px);
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, views.size()); ++i)
    text += fmt::format("{}{} ({} px)", text.empty() ? "" : ", ", views[i]->image,
                        two_digits(views[i]->rms_px));
  return wrapped("worst      ", text, 11);
}

std::string_view noise_source(const Calibration& calibration) {
  return calibration.sigma_from_residuals ? "from the residuals" : "as stated";
}

// "selected   5 views, one after the other .." and a line for each.
std::string selection_text(const std::optional<ViewSelection>& selection) {
  if (!selection) return "";
  std::string text = fmt::format(
      "selected   {}; the projection's sd at infinity by the corners (RMS over the image) after "
      "each:\n",
      counted(selection->views.size(), "view"));
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

// All of the time: what the parts do not name is the rest (checks, choice of views, advice).
std::string time_text(const CalibrationAnswer& answer) {
  const CommandSeconds& all = answer.seconds;
  const CalibrateSeconds& parts = answer.calibration.seconds;
  const double named =
      all.read + all.refine + parts.start + parts.solve + parts.covariance + all.write;
  const std::string refine = all.refine > 0 ? fmt::format("refine {:.2f}, ", all.refine) : "";
  const std::string write = all.write > 0 ? fmt::format("write {:.2f}, ", all.write) : "";
  return fmt::format(
      "time       {:.2f} s: read {:.2f}, {}start {:.2f}, solve {:.2f}, covariance {:.2f}, {}rest "
      "{:.2f}\n",
      all.total, all.read, refine, parts.start, parts.solve, parts.covariance, write,
      std::max(0.0, all.total - named));
}

}  // namespace

std::string readout_text(const Readout& readout) {
  return fmt::format("{} of the rows, the {} first (from {} frames)",
                     term_text(1e3 * std::abs(readout.seconds), 1e3 * readout.sigma_s, "ms"),
                     readout.seconds < 0 ? "last" : "upper", readout.num_views);
}

std::string verdict_sentence(const Calibration& calibration, bool chosen) {
  if (!is_answer(calibration.status))
    return no_answer_text(calibration.status, calibration.findings);
  return ok_text(calibration.findings) + extent_of(calibration, chosen);
}

std::string halves_text(const HalvesCheck& halves) {
  return halves.source.empty()
             ? "two halves of the views"
             : fmt::format("the pictures of {} and the other pictures", halves.source);
}

std::string noise_sentence(const Calibration& calibration) {
  if (!calibration.sigma_of_corners)
    return fmt::format("{} px per coordinate ({})", two_digits(calibration.sigma_px),
                       noise_source(calibration));
  if (calibration.model_error_px == 0) {
    const bool is_exceeded =
        std::ranges::count(calibration.findings, code::noise_understated.name, &Finding::code) > 0;
    return std::string("each corner's own covariance, which ") +
           (is_exceeded ? "the residuals exceed" : "explains the residuals");
  }
  return fmt::format(
      "each corner's own covariance, and {} px per coordinate for errors of lens and target",
      two_digits(calibration.model_error_px));
}

std::string advice_sentence(const std::optional<AdvisedView>& advice) {
  return advice ? advice->sentence : "none of the views tried would improve the answer";
}

std::string calibration_summary(const CalibrationAnswer& answer, const SummaryOptions& options) {
  const Calibration& calibration = answer.calibration;
  const bool answered = is_answer(calibration.status);
  std::string text = verdict_lines(verdict_sentence(calibration, options.chosen),
                                   calibration.status, calibration.findings);
  text += findings_text(without_reason(calibration.findings), "");
  if (calibration.camera && answered) text += camera_table(calibration);
  text += fixed_text(calibration.fixed) + scales_text(calibration);
  if (answered) {
    text += projection_text(calibration, options);
    text += fmt::format("noise      {}\n", noise_sentence(calibration));
    text += worst_pictures_text(calibration);
  }
  text += dropped_corners_text(calibration, options.verbose);
  text += selection_text(answer.selection);
  if (!options.verbose) return text;
  text += steps_text(calibration.steps);
  return text + time_text(answer);
}

}  // namespace tagcal::tools
