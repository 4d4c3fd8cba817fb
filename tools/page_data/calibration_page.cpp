#include "page_data/pages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "page_data/page_parts.hpp"
#include "report/calibration_report.hpp"
#include "report/json_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal::tools {
namespace {

// The keys of the summary.
void add_summary(const PageContent& content, const std::vector<PageCorner>& corners,
                 PageJson& page) {
  const Calibration& c = content.calibration;
  const bool has_corners = !corners.empty();
  const bool answered = is_answer(c.status);
  page["rms_px"] = has_corners && answered ? significant(c.rms_px) : PageJson();
  page["noise_px"] =
      !c.sigma_of_corners && c.sigma_px > 0 && answered ? significant(c.sigma_px) : PageJson();
  page["noise_sentence"] = answered && c.sigma_px > 0 ? PageJson(noise_sentence(c)) : PageJson();
  page["num_corners"] = has_corners ? PageJson(c.num_corners) : PageJson();
  page["num_pictures"] = has_corners ? PageJson(c.views.size()) : PageJson();
  page["num_rejected"] = has_corners ? PageJson(c.outliers.size()) : PageJson();
  page["seconds"] = content.seconds ? significant(*content.seconds, 3) : PageJson();
}

// Adds the poses of the views, and what follows from them.
void add_views(const Dataset& dataset, const std::optional<double>& camera_error_px, int threads,
               PageContent& content) {
  Calibration& calibration = content.calibration;
  ViewPoses poses = poses_of_views(dataset, *calibration.camera, camera_error_px,
                                   static_cast<std::size_t>(threads));
  std::ranges::move(poses.findings, std::back_inserter(calibration.findings));
  if (poses.pixels.empty()) return;
  calibration.views = std::move(poses.views);
  calibration.outliers = std::move(poses.outliers);
  calibration.num_corners = static_cast<int>(poses.pixels.size());
  calibration.rms_px = poses.rms_px;
  if (calibration.seen.hull().empty())
    calibration.seen = SeenRegion(calibration.camera->image_size, poses.pixels);
  calibration.sigma_px = poses.sigma_px;
  calibration.sigma_from_residuals = poses.sigma_from_residuals;
}

void note_what_is_missing(bool has_data, PageContent& content) {
  auto& notes = content.notes;
  if (!content.calibration.claim)
    notes.emplace_back(
        "The file has no covariance: the uncertainty of the projection is not known.");
  if (!has_data)
    notes.emplace_back(
        "Views and residuals are not shown, because no data set was given: --dataset D, or "
        "--target T.yaml and the pictures.");
  else
    notes.emplace_back(
        "The poses of the views were estimated again under the camera of the file, each by "
        "itself.");
  notes.emplace_back(
      "A file of a camera has no model ladder, no comparison of two halves of the views, no shape "
      "of the board and no next view to take: tagcal calibrate --report shows them.");
}

}  // namespace

PageJson calibration_page(const PageContent& content) {
  const Calibration& c = content.calibration;
  const ImageSize size = c.camera ? c.camera->image_size : content.dataset.image_size;
  std::vector<std::string> notes = content.notes;
  const std::vector<PageCorner> corners = page_corners(content);
  const std::vector<Thumbnail> pictures =
      thumbnails(picture_files_of(content), size, content.threads);
  PageJson page = {{"format", 1},
                   {"kind", "calibration"},
                   {"title", content.title},
                   {"verdict", verdict_json(c.status, c.findings,
                                            verdict_sentence(c, content.chosen.value_or(false)))},
                   {"status", status_name(c.status)},
                   {"model", c.model.empty() ? PageJson() : PageJson(c.model)},
                   {"chosen", content.chosen ? PageJson(*content.chosen) : PageJson()},
                   {"made_by", made_by_json()}};
  page["findings"] = page_findings_json(c.findings);
  page["image_size"] = {size.width, size.height};
  page["parameters"] = parameters_json(c);
  add_summary(content, corners, page);
  page["seen"] = seen_json(c.seen);
  page["projection"] = projection_maps_json(content);
  page["corners"] = corners_json(corners);
  page["views"] = views_json(content, corners, pictures, notes);
  page["boards"] = boards_json(content.dataset.boards);
  if (c.readout) page["readout"] = readout_json(*c.readout);
  page["warp"] = warp_json(content.dataset.boards, c.board_warp);
  page["ladder"] = ladder_json(c);
  page["halves"] = halves_sentence_json(c.halves);
  page["advice"] = advice_json(content);
  page["formats"] = formats_json(c, notes);
  page["notes"] = notes;
  return page;
}

Calibration calibration_of(const CalibrationFile& file) {
  Calibration calibration;
  calibration.status = Status::ok;
  calibration.camera = file.camera;
  calibration.model =
      file.model.empty() ? std::string(full_model(file.camera.lens).name()) : file.model;
  calibration.covariance = file.covariance;
  if (const UncertainCamera claim = uncertain_camera(file); claim.model) calibration.claim = claim;
  calibration.fixed = file.fixed;
  calibration.sigmas = file.sigmas;
  if (file.sigmas.empty())  // not known, which 0 would not say
    calibration.sigmas.assign(parameters(file.camera.lens).size(), std::nan(""));
  calibration.seen = file.seen;
  calibration.findings = file.findings;
  for (Finding& finding : calibration.findings)
    if (finding.code.empty()) finding.code = "calibration_file";  // older files have no codes
  return calibration;
}

PageContent content_from_file(const std::string& file_and_name, Input* input, int threads) {
  const CalibrationFile file = read_camera(file_and_name);
  PageContent content;
  content.threads = threads;
  content.calibration = calibration_of(file);
  content.title = fmt::format("{}: {}", last_part(file_and_name), content.calibration.model);
  note_what_is_missing(input != nullptr, content);
  if (!input) return content;
  check_image_size(file.camera.image_size, file_and_name, *input);
  find_views(*input, threads, true, &file.camera);
  for (const std::string& warning : input->warnings)
    add(content.calibration.findings, code::input, warning);
  content.pictures = input->files;
  content.times_s = input->times_s;
  content.dataset = input->dataset;
  add_views(content.dataset, file.camera_error_px, threads, content);
  return content;
}

}  // namespace tagcal::tools
