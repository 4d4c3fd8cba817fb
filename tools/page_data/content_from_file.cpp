#include "page_data/content_from_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "page_data/page_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

using Eigen::Vector2d;

struct EstimatedView {
  std::optional<CalibratedView> view;
  std::vector<Outlier> outliers;
  std::vector<Vector2d> used;
  double square_px2 = 0;
};

EstimatedView estimate_view(const Dataset& dataset, std::size_t index, const Camera& camera,
                            const std::map<CornerId, Eigen::Vector3d>& points,
                            const std::optional<double>& camera_error_px) {
  const View& view = dataset.views[index];
  EstimatedView result;
  const ViewCorrespondences seen = view_correspondences(view, points, camera_error_px);
  if (seen.correspondences.empty()) return result;
  const PoseEstimate pose = estimate_pose(seen, camera);
  if (!is_answer(pose.status)) return result;
  result.view.emplace();
  result.view->image = view.image;
  result.view->view = index;
  result.view->camera_from_world = pose.camera_from_target();
  for (std::size_t i = 0; i < seen.correspondences.size(); ++i) {
    const Correspondence& c = seen.correspondences[i];
    const auto at = project(camera.lens, pose.camera_from_target() * c.point);
    const double residual = at ? (c.pixel - *at).norm() : std::nan("");
    if (std::ranges::count(pose.outliers, i) > 0 || !at) {
      const auto found = std::ranges::find(view.observations, seen.ids[i], &Observation::id);
      result.outliers.push_back({view.image, seen.ids[i], residual, index,
                                 static_cast<std::size_t>(found - view.observations.begin())});
      continue;
    }
    result.used.push_back(c.pixel);
    result.square_px2 += residual * residual;
  }
  result.view->num_corners = static_cast<int>(result.used.size());
  result.view->rms_px = std::sqrt(
      result.square_px2 / static_cast<double>(std::max<std::size_t>(1, result.used.size())));
  return result;
}

// Adds the poses of the views, and what follows from them.
void add_views(const Dataset& dataset, const std::optional<double>& camera_error_px, int threads,
               PageContent& content) {
  Calibration& calibration = content.calibration;
  const auto points = points_in_world(dataset.boards);
  std::vector<EstimatedView> views(dataset.views.size());
  parallel_for(views.size(), threads, [&](std::size_t i) {
    views[i] = estimate_view(dataset, i, *calibration.camera, points, camera_error_px);
  });
  std::vector<Vector2d> used;
  double square_px2 = 0;
  for (EstimatedView& one : views) {
    if (!one.view) continue;
    calibration.views.push_back(*one.view);
    std::ranges::move(one.outliers, std::back_inserter(calibration.outliers));
    used.insert(used.end(), one.used.begin(), one.used.end());
    square_px2 += one.square_px2;
  }
  if (used.empty()) return;
  calibration.num_corners = static_cast<int>(used.size());
  calibration.rms_px = std::sqrt(square_px2 / static_cast<double>(used.size()));
  if (calibration.seen.hull().empty())
    calibration.seen = SeenRegion(calibration.camera->image_size, used);
  // Six coordinates of each view went into its pose.
  const double freedom =
      2.0 * static_cast<double>(used.size()) - 6.0 * static_cast<double>(calibration.views.size());
  if (freedom > 0) calibration.sigma_px = std::sqrt(square_px2 / freedom);
  calibration.sigma_from_residuals = true;
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
  const std::size_t without = content.dataset.views.size() - content.calibration.views.size();
  if (without > 0)
    content.notes.push_back(fmt::format("{} of {} views have no pose under this camera.", without,
                                        content.dataset.views.size()));
  return content;
}

}  // namespace tagcal::tools
