#include "tagcal/io/calibration_file.hpp"

#include <fmt/format.h>

#include <cassert>
#include <set>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/tagcal_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;
namespace {

std::string projection_yaml(const Calibration& calibration) {
  std::string text = seen_yaml(calibration.seen);
  if (calibration.projection.empty()) return text;
  text += "projection_uncertainty:\n";
  for (const ProjectionUncertainty& p : calibration.projection)
    text += fmt::format("   - distance_m: {}\n     ", number_yaml(p.distance_m)) +
            matrix_yaml("sigma_px", p.sigma_px, 5);
  return text;
}

// The further keys of a view of model weak: its scale, and the uncertainty.
std::string weak_view_yaml(const CalibratedView& view) {
  if (!view.scale_px_per_m) return "";
  return (view.mirrored ? pose_lines(*view.mirrored, "mirrored_") : "") +
         fmt::format("     scale_px_per_m: {}\n     scale_sigma_px_per_m: {}\n     ",
                     *view.scale_px_per_m, number_yaml(view.scale_sigma_px_per_m)) +
         matrix_yaml("pose_covariance", view.covariance, 5);
}

std::string views_yaml(const std::vector<CalibratedView>& views) {
  std::string text = views.empty() ? "views: []\n" : "views:\n";
  std::set<std::string> names;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CalibratedView& view = views[i];
    text += image_line(view.image, i, names) + pose_lines(view.camera_from_world, "") +
            weak_view_yaml(view) +
            fmt::format("     num_corners: {}\n     rms_px: {}\n", view.num_corners, view.rms_px);
  }
  return text;
}

}  // namespace

CalibrationFile calibration_file(const Calibration& calibration) {
  assert(calibration.camera && is_answer(calibration.status));
  CalibrationFile file;
  file.camera = *calibration.camera;
  file.model = calibration.model;
  file.fixed = calibration.fixed;
  file.sigmas = calibration.sigmas;
  file.covariance = calibration.covariance;
  if (calibration.claim) {
    file.claim_model = calibration.claim->model->name();
    file.claim_covariance = calibration.claim->covariance;
  }
  file.seen = calibration.seen;
  file.camera_error_px = camera_error_px(calibration);
  file.findings = calibration.findings;
  return file;
}

std::string calibration_yaml(const Calibration& calibration) {
  assert(calibration.camera && is_answer(calibration.status));
  return "%YAML:1.0\n---\n" + camera_yaml(*calibration.camera, calibration.model) +
         fmt::format(
             "avg_reprojection_error: {}\nmodel: {}\nstatus: {}\nrms_px: {}\nsigma_px: {}\n"
             "sigma_from_residuals: {}\ncamera_error_px: {}\n",
             calibration.rms_px, text_yaml(calibration.model),
             text_yaml(status_name(calibration.status)), calibration.rms_px, calibration.sigma_px,
             int{calibration.sigma_from_residuals}, camera_error_px(calibration)) +
         uncertainty_yaml(calibration_file(calibration)) + projection_yaml(calibration) +
         fmt::format("num_views: {}\nnum_corners: {}\nnum_outliers: {}\n", calibration.views.size(),
                     calibration.num_corners, calibration.outliers.size()) +
         views_yaml(calibration.views) + findings_yaml(calibration.findings);
}

CalibrationFile read_calibration(const std::filesystem::path& file) {
  return usable_camera(read_one_camera(file.string()), file.string());
}

std::string quoted_yaml(std::string_view text) { return text_yaml(text); }

}  // namespace tagcal
