#include "python/calibration.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/findings.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/lens_fit.hpp"
#include "tagcal/internal/text.hpp"

// The result of `calibrate`.

namespace tagcal::python {
namespace {

std::string calibration_text(const Calibration& c) {
  if (!is_answer(c.status)) return refusal(c.status, c.findings);
  std::string text = std::string(status_name(c.status)) + ", " + c.model;
  if (const std::optional<Camera> camera = camera_of_answer(c)) {
    const double f = parameters(camera->lens)[0];
    text += ", f " + internal::with_sigma(f, c.sigmas.empty() ? 0 : c.sigmas[0]) + " px";
  }
  return text + ", rms " + number(c.rms_px, 3) + " px" + warnings_text(c.findings);
}

NumbersByName sigmas_of_answer(const Calibration& c) {
  if (!camera_of_answer(c)) return {};
  return by_name(c.camera->lens, c.sigmas);
}

std::optional<py::array_t<double>> covariance_of_answer(const Calibration& c) {
  if (!camera_of_answer(c) || c.covariance.size() == 0) return std::nullopt;
  return matrix_array(c.covariance);
}

std::optional<UncertainCamera> claim_of_answer(const Calibration& c) {
  return camera_of_answer(c) ? c.claim : std::nullopt;
}

std::vector<std::string> free_names(const Calibration& c) {
  std::vector<std::string> names;
  if (c.model.empty()) return names;
  for (const FreeParameter& free : free_parameters(c.model, c.fixed)) names.emplace_back(free.name);
  return names;
}

// Empty without an answer, except for model weak, whose poses need no focal length.
std::vector<CalibratedView> views_of_answer(const Calibration& c) {
  if (!is_answer(c.status) && c.model != "weak") return {};
  return c.views;
}

void define_answer(Record<Calibration>& record) {
  record.field("status", &Calibration::status,
               "\"ok\" is an answer; \"focal_not_observable\", \"not_observable\", \"degenerate\", "
               "\"no_consensus\" and \"not_converged\" are none.");
  record.field("model", &Calibration::model,
               "The model that was fitted, such as \"opencv5\"; \"\" without a fit.");
  record.field("camera", &camera_of_answer,
               "The Camera; None without an answer, and with model \"weak\", where each view has "
               "its own scale.");
  record.field("sigmas", &sigmas_of_answer,
               "Standard deviation of each lens parameter by name, 0 for a held one; empty "
               "without a camera.");
  record.field("free_parameters", &free_names,
               "The names of the model's free parameters: the rows of `covariance`.");
  record.field("covariance", &covariance_of_answer,
               "(K, K), of the free parameters; None without a camera. It follows from `claim`.");
  record.field("claim", &claim_of_answer,
               "The Claim: what is known of the lens, by the largest model that the data need "
               "(\"auto\") or by the model asked for. It includes the choice of the model and the "
               "priors, and all other uncertainties of the lens follow from it. None without a "
               "camera.");
  record.field("fixed", &Calibration::fixed, "Lens parameters that were held, by name.");
  record.field("rms_px", &Calibration::rms_px, "sqrt(sum |r|^2 / corners) over the inliers.");
  record.field("sigma_px", &Calibration::sigma_px, "Noise per coordinate behind the covariance.");
  record.field("sigma_from_residuals", &Calibration::sigma_from_residuals,
               "True if that noise was estimated from the residuals.");
  record.field("sigma_of_corners", &Calibration::sigma_of_corners,
               "True if the noise is the corners' own and model_error_px; sigma_px is 1 then.");
  record.field("model_error_px", &Calibration::model_error_px,
               "Noise per coordinate beyond the corners' own covariances, from the residuals: "
               "errors of the models of lens and target.");
  record.field("variance_inflation", &Calibration::variance_inflation,
               "Variance of the views' contributions over that of independent residuals.");
}

void define_diagnosis(Record<Calibration>& record) {
  record.field("projection", &Calibration::projection,
               "Maps of the projection's standard deviation, one per distance; none without a "
               "covariance.");
  record.field("seen", &Calibration::seen, "The part of the image with corners.");
  record.field("board_warp", &Calibration::board_warp,
               "How the board differs from its file, with one flat board; else None.");
  record.field("readout", &Calibration::readout,
               "The time that the rows of a rolling shutter take, with times_s; else None.");
  record.field("halves", &Calibration::halves,
               "The cross-validation, with six views or more; else None.");
  record.field("weak_directions", &Calibration::weak_directions,
               "The weakest first, at most three.");
  record.field("views", &views_of_answer,
               "The views that take part, with poses; none without an answer, except for model "
               "\"weak\", whose poses need no focal length.");
  record.field("outliers", &Calibration::outliers, "The rejected corners.");
  record.field("num_corners", &Calibration::num_corners, "The inliers.");
  record.field("num_iterations", &Calibration::num_iterations, "Of the solver.");
  record.field("steps", &Calibration::steps,
               "The models that \"auto\" tried, in the order of the ladder.");
  record.field("findings", &Calibration::findings, "What the estimate found out about its data.");
  record.field("seconds", &Calibration::seconds, "Wall-clock times.");
  record.def_property_readonly(
      "is_answer", [](const Calibration& c) { return is_answer(c.status); },
      "True if the status is \"ok\".");
  record.def_property_readonly(
      "solver_camera",
      [](const Calibration& c) { return c.model == "weak" ? std::nullopt : c.camera; },
      "The last state of the solver, whatever the status: for diagnosis only. None if there is "
      "none.");
  record.def_property_readonly("camera_error_px", &camera_error_px,
                               "The error of a projection by this camera per coordinate, besides "
                               "the noise of a corner: `estimate_view_pose` takes it.");
  record.def_property_readonly(
      "uncertain_camera", [](const Calibration& c) { return known_camera(c); },
      "The camera with its covariance. Raises Error if there is none.");
}

}  // namespace

void bind_calibration(py::module_& m) {
  Record<Calibration> record(m, "Calibration", "A camera, how sure it is, and why.");
  define_answer(record);
  define_diagnosis(record);
  record.representation(&calibration_text);
}

}  // namespace tagcal::python
