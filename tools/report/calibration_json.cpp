#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "job/plain_text.hpp"
#include "job/shown_parameters.hpp"
#include "report/calibration_report.hpp"
#include "report/findings.hpp"
#include "report/json_parts.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

// Null if one of the coefficients is unknown.
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

// What is known of the lens: the covariance of the free parameters of a model.
Json claim_json(const Calibration& calibration) {
  if (!calibration.claim || !is_answer(calibration.status)) return nullptr;
  const UncertainCamera& claim = *calibration.claim;
  Json names = Json::array();
  for (const FreeParameter& free : claim.model->free()) names.push_back(free.name);
  return {{"model", claim.model->name()},
          {"parameters", std::move(names)},
          {"covariance", matrix_json(claim.covariance)}};
}

// null: no bound.
Json pixels_json(double sigma_px, const ImageSize& size) {
  return has_bound(sigma_px, size) ? Json(sigma_px) : Json();
}

Json projection_json(const Calibration& calibration) {
  Json list = Json::array();
  for (const ProjectionUncertainty& p : calibration.projection) {
    const double centre = p.sigma_px(p.grid.rows / 2, p.grid.columns / 2);
    list.push_back({{"distance_m", distance_json(p.distance_m)},
                    {"rms_px", pixels_json(p.region_px, p.grid.size)},
                    {"max_px", pixels_json(p.region_max_px, p.grid.size)},
                    {"centre_px", pixels_json(centre, p.grid.size)},
                    {"whole_image_max_px", pixels_json(largest_px(p), p.grid.size)},
                    {"nodes_without_ray", nodes_without_ray(p)}});
  }
  return list;
}

Json halves_json(const std::optional<HalvesCheck>& halves) {
  if (!halves) return nullptr;
  return {{"source", halves->source.empty() ? Json() : Json(halves->source)},
          {"distance_m", distance_json(halves->distance_m)},
          {"difference_px", halves->difference_px},
          {"predicted_px", halves->predicted_px},
          {"ratio", halves->ratio},
          {"disagree", halves->disagree}};
}

Json warp_json(const std::optional<BoardWarp>& warp) {
  if (!warp) return nullptr;
  return {{"bend_mm", {warp->bend_mm.x(), warp->bend_mm.y()}},
          {"sigma_mm", {warp->sigma_mm.x(), warp->sigma_mm.y()}},
          {"twist_mm", warp->twist_mm},
          {"sigma_twist_mm", warp->sigma_twist_mm},
          {"aspect", warp->aspect},
          {"sigma_aspect", warp->sigma_aspect}};
}

Json weak_directions_json(const Calibration& calibration) {
  Json list = Json::array();
  for (const WeakDirection& weak : calibration.weak_directions)
    list.push_back({{"parameter", weak.parameter},
                    {"sigma_px", pixels_json(weak.sigma_px, calibration.camera->image_size)},
                    {"sentence", weak.sentence}});
  return list;
}

Json advice_json(const std::optional<AdvisedView>& advice) {
  if (!advice) return nullptr;
  return {{"tilt_deg", advice->tilt_rad / internal::kDegree},
          {"distance_m", advice->distance_m},
          {"pixel", {advice->pixel.x(), advice->pixel.y()}},
          {"focal_sigma_now_px", advice->focal_sigma_now_px},
          {"focal_sigma_px", advice->focal_sigma_px},
          {"projection_px", advice->projection_px},
          {"fills", advice->fills},
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
                    {"difference_px", optional_json(step.difference_px)},
                    {"weight", step.weight},
                    {"taken", step.taken},
                    {"sentence", step.sentence}});
  }
  return list;
}

Json view_json(const CalibratedView& view) {
  Json json = {{"image", view.image}};
  json.update(pose_json(view.camera_from_world));
  if (view.scale_px_per_m)
    json.update({{"mirrored", view.mirrored ? pose_json(*view.mirrored) : Json()},
                 {"scale_px_per_m", *view.scale_px_per_m},
                 {"scale_sigma_px_per_m", view.scale_sigma_px_per_m},
                 {"covariance", matrix_json(view.covariance)}});
  json.update({{"num_corners", view.num_corners}, {"rms_px", view.rms_px}});
  return json;
}

// Empty without an answer, except for model weak, whose poses need no focal length.
Json views_json(const Calibration& calibration) {
  Json list = Json::array();
  if (!is_answer(calibration.status) && calibration.model != "weak") return list;
  for (const CalibratedView& view : calibration.views) list.push_back(view_json(view));
  return list;
}

Json selection_json(const std::optional<ViewSelection>& selection) {
  if (!selection) return nullptr;
  Json views = Json::array();
  for (const SelectedView& view : selection->views)
    views.push_back({{"image", view.image},
                     {"num_corners", view.num_corners},
                     {"projection_px", view.projection_px}});  // infinity becomes null
  return {{"views", std::move(views)}, {"all_views_projection_px", selection->all_px}};
}

Json frames_json(const std::optional<FrameTally>& frames) {
  if (!frames) return nullptr;
  return {
      {"all", frames->all},   {"looked_at", frames->looked_at}, {"with_board", frames->with_board},
      {"fast", frames->fast}, {"no_pose", frames->no_pose},     {"add_nothing", frames->nothing},
      {"used", frames->used}};
}

Json seconds_json(const CalibrationAnswer& answer) {
  const CalibrateSeconds& spent = answer.calibration.seconds;
  return {{"read", answer.seconds.read},    {"refine", answer.seconds.refine},
          {"start", spent.start},           {"solve", spent.solve},
          {"covariance", spent.covariance}, {"write", answer.seconds.write},
          {"total", answer.seconds.total}};
}

}  // namespace

std::string calibration_json(const CalibrationAnswer& answer, const std::string& name) {
  const Calibration& calibration = answer.calibration;
  const bool known = calibration.camera.has_value();
  Json json = Json::object();
  if (!name.empty()) json["data_set"] = name;
  json.update({{"status", status_name(calibration.status)},
               {"model", calibration.model.empty() ? Json() : Json(calibration.model)},
               {"camera", camera_json(calibration, &Shown::value)},
               {"sigma", camera_json(calibration, &Shown::sigma)},
               {"fixed", calibration.fixed},
               {"claim", claim_json(calibration)},
               {"rms_px", known ? Json(calibration.rms_px) : Json()},
               {"sigma_px", known ? Json(calibration.sigma_px) : Json()},
               {"sigma_of_corners", calibration.sigma_of_corners},
               {"corner_error_px", answer.corner_error_px},
               {"model_error_px", known ? Json(calibration.model_error_px) : Json()},
               {"variance_inflation", known ? Json(calibration.variance_inflation) : Json()},
               {"num_views", calibration.views.size()},
               {"num_corners", calibration.num_corners},
               {"num_outliers", calibration.outliers.size()},
               {"outliers", outliers_json(calibration.outliers)},
               {"views", views_json(calibration)},
               {"projection", projection_json(calibration)},
               {"seen_share", known ? Json(calibration.seen.share()) : Json()},
               {"halves", halves_json(calibration.halves)},
               {"board_warp", warp_json(calibration.board_warp)},
               {"readout", readout_json(calibration.readout)},
               {"weak_directions", weak_directions_json(calibration)},
               {"advice", advice_json(answer.advice)},
               {"selection", selection_json(answer.selection)},
               {"frames", frames_json(answer.frames)},
               {"steps", steps_json(calibration.steps)},
               {"findings", findings_json(calibration.findings)},
               {"warnings", sentences(calibration.findings)},
               {"seconds", seconds_json(answer)}});
  return json_text(json);
}

std::string failure_json(const std::string& name, const std::string& error) {
  return json_text({{"data_set", name}, {"error", error}});
}

}  // namespace tagcal::tools
