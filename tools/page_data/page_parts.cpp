#include "page_data/page_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <string_view>

#include "draw/heat_map.hpp"
#include "job/command_line.hpp"
#include "job/shown_parameters.hpp"
#include "job/terminal.hpp"
#include "job/warning_groups.hpp"
#include "report/calibration_report.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday);
}

// "Ceres 2.1.0, OpenCV 4.6.0, .." as keys and values.
PageJson libraries_json() {
  PageJson json = PageJson::object();
  std::string_view rest = TAGCAL_BUILT_WITH;
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(", "));
    rest.remove_prefix(std::min(rest.size(), one.size() + 2));
    const std::size_t blank = one.rfind(' ');
    if (blank != std::string_view::npos)
      json[std::string(one.substr(0, blank))] = one.substr(blank + 1);
  }
  return json;
}

std::string level_of(Status status, std::span<const Finding> findings) {
  if (!is_answer(status)) return "no_answer";
  if (status == Status::ambiguous) return "ambiguous";
  const bool warns = std::ranges::count(findings, Severity::warning, &Finding::severity) > 0;
  return warns ? "warnings" : "ok";
}

std::string parameter_text(const Shown& p) {
  if (!std::isfinite(p.value)) return "not known";
  return with_sigma(p.value, p.sigma) + (p.sigma == 0 ? ", held" : "");
}

// The median distance of the boards' corners from the camera; 0: not known.
double median_distance_m(const PageContent& content) {
  const auto points = points_in_world(content.dataset.boards);
  std::vector<double> all;
  for (const CalibratedView& view : content.calibration.views) {
    if (view.view >= content.dataset.views.size() || view.scale_px_per_m) continue;
    for (const Observation& seen : content.dataset.views[view.view].observations)
      if (const auto found = points.find(seen.id); found != points.end())
        all.push_back((view.camera_from_world * found->second).norm());
  }
  if (all.empty()) return 0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

PageJson map_json(const ProjectionUncertainty& p) {
  return {{"distance_m", significant(p.distance_m, 3)},
          {"columns", p.grid.columns},
          {"rows", p.grid.rows},
          {"sigma_px", grid_json(p.sigma_px)},
          {"region_px", significant(p.region_px)},
          {"max_px", significant(largest_px(p))},
          {"centre_px", significant(p.sigma_px(p.grid.rows / 2, p.grid.columns / 2))}};
}

}  // namespace

std::string last_part(const std::string& path) {
  std::filesystem::path plain = std::filesystem::path(path).lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();  // of "desk/"
  const std::string name = plain.filename().string();
  return name.empty() || name == "." || name == ".." ? path : name;
}

PageJson verdict_json(Status status, std::span<const Finding> findings,
                      const std::string& sentence) {
  return {{"level", level_of(status, findings)}, {"sentence", sentence}};
}

PageJson page_findings_json(std::span<const Finding> findings) {
  PageJson list = PageJson::array();
  for (const Finding& finding : in_groups(findings))
    list.push_back({{"code", finding.code},
                    {"severity", finding.severity == Severity::refusal
                                     ? "error"
                                     : std::string(severity_name(finding.severity))},
                    {"sentence", finding.sentence}});
  return list;
}

PageJson made_by_json() {
  return {{"command", command_as_typed()},
          {"version", TAGCAL_VERSION},
          {"date", today()},
          {"libraries", libraries_json()}};
}

PageJson parameters_json(const Calibration& calibration) {
  PageJson list = PageJson::array();
  if (!calibration.camera) return list;
  const std::vector<Shown> shown = shown_parameters(calibration);
  for (std::size_t i = 0; i < num_shown(calibration); ++i) {
    const bool is_length = i < 4;  // fx, fy, cx, cy
    list.push_back({{"name", shown[i].name},
                    {"value", significant(shown[i].value, 10)},
                    {"sigma", significant(shown[i].sigma)},
                    {"text", parameter_text(shown[i])},
                    {"unit", is_length ? "px" : ""}});
  }
  return list;
}

PageJson projection_maps_json(const PageContent& content) {
  const Calibration& calibration = content.calibration;
  PageJson list = PageJson::array();
  if (!is_answer(calibration.status) || !calibration.claim) return list;
  const UncertainCamera& lens = *calibration.claim;
  const ImageGrid grid{calibration.camera->image_size};
  std::vector<Eigen::Vector2d> samples = calibration.seen.samples();
  if (samples.empty()) samples = grid.pixels();
  double middle = median_distance_m(content);
  for (const ProjectionUncertainty& p : calibration.projection)
    if (std::isfinite(p.distance_m)) middle = p.distance_m;
  if (middle == 0) middle = 1;
  for (const double distance : {middle, kInfinitelyFar})
    list.push_back(map_json(projection_uncertainty(lens, grid, samples, distance)));
  return list;
}

PageJson seen_json(const SeenRegion& seen) {
  if (seen.hull().empty()) return nullptr;
  PageJson hull = PageJson::array();
  for (const Eigen::Vector2d& corner : seen.hull()) hull.push_back(point_json(corner));
  return {{"share", significant(seen.share())}, {"hull", std::move(hull)}};
}

PageJson ladder_json(const Calibration& calibration) {
  PageJson list = PageJson::array();
  for (const ModelStep& step : calibration.steps)
    list.push_back(
        {{"model", step.model},
         {"num_parameters", step.num_parameters},
         {"bic", significant(step.bic, 8)},
         {"difference_px", step.difference_px ? significant(*step.difference_px) : PageJson()},
         {"taken", step.taken},
         {"weight", significant(step.weight)},
         {"sentence", step.sentence}});
  return list;
}

PageJson halves_sentence_json(const std::optional<HalvesCheck>& halves) {
  if (!halves) return nullptr;
  return {{"ratio", significant(halves->ratio)},
          {"disagree", halves->disagree},
          {"sentence",
           fmt::format("Cross-check: {} {}; their projections differ by {} px at {}; the lenses "
                       "by at most {:.2f} of what noise explains.",
                       halves_text(*halves), halves->disagree ? "disagree" : "agree",
                       two_digits(halves->difference_px), distance_text(halves->distance_m),
                       halves->ratio)}};
}

}  // namespace tagcal::tools
