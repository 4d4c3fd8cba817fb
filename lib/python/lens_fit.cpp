#include "tagcal/estimate/lens_fit.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/calibration.hpp"
#include "python/camera.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"

// A lens of one model that projects as a lens of another does.

namespace tagcal::python {
namespace {

LensFit fit(const CameraLike& camera, const std::string& model, double max_difference_px) {
  const CalibrationFile known = known_camera(camera, "camera");
  const UncertainCamera claim = uncertain_camera(known);
  LensFitSource source{claim.camera, {}, claim.covariance, known.seen};
  if (claim.model) source.free = claim.model->free();
  if (!(max_difference_px >= 0 && std::isfinite(max_difference_px)))
    throw Error("max_difference_px: must be >= 0 (0: 0.1 px), got " + number(max_difference_px));
  const Model& named = Model::named(model);
  py::gil_scoped_release release;
  return fit_lens(source, named, {max_difference_px});
}

// False if no lens of the model sees what the source sees.
bool has_lens(const LensFit& fit) { return fit.difference_px.size() > 0; }

std::optional<Camera> camera_of_fit(const LensFit& fit) {
  return has_lens(fit) ? std::optional(fit.camera) : std::nullopt;
}

std::optional<py::array_t<double>> covariance_of_fit(const LensFit& fit) {
  if (fit.covariance.size() == 0) return std::nullopt;
  return matrix_array(fit.covariance);
}

void bind_fit(py::module_& m) {
  Record<LensFitDifference>(m, "LensFitDifference",
                            "The pixel by a fitted lens minus that by its source.")
      .field("max_px", &LensFitDifference::max_px, "The largest.")
      .field("rms_px", &LensFitDifference::rms_px, "sqrt(mean |difference|^2).")
      .field("share_without", &LensFitDifference::share_without,
             "Of the pixels: the fitted lens has no projection there.")
      .representation([](const LensFitDifference& d) {
        return "rms " + number(d.rms_px, 3) + " px, at most " + number(d.max_px, 3) + " px";
      });
  Record<LensFit>(m, "LensFit", "The lens of a model that projects as another lens does.")
      .field(
          "model", [](const LensFit& f) { return std::string(f.model->name()); }, "Its model.")
      .field("camera", &camera_of_fit,
             "The Camera; None if no lens of the model sees what the source sees.")
      .field("refusal", &LensFit::refusal,
             "Why the camera does not replace the source; None if it does.")
      .field(
          "sigmas", [](const LensFit& f) { return by_name(f.camera.lens, f.sigmas); },
          "Standard deviations by name; empty without the covariance of the source.")
      .field("covariance", &covariance_of_fit,
             "(K, K), of the model's free parameters; None without that of the source.")
      .field("seen", &LensFit::seen, "The difference over the region where corners were.")
      .field("image", &LensFit::image, "The difference over the whole image.")
      .field("grid", &LensFit::grid, "The nodes of the map.")
      .field(
          "difference_px", &LensFit::difference_px,
          "(rows, columns): |difference| at the nodes; NaN where the source has no ray, infinite "
          "where the fitted lens has no projection.")
      .representation([](const LensFit& f) {
        if (f.refusal) return "refused: " + *f.refusal;
        return std::string(f.model->name()) + ", rms " + number(f.seen.rms_px, 3) +
               " px, at most " + number(f.seen.max_px, 3) + " px";
      });
}

}  // namespace

void bind_lens_fit(py::module_& m) {
  bind_fit(m);
  constexpr const char* kDocumentation =
      "The lens of a model that projects as that of the camera does, in the same frame: poses and "
      "pixels keep their meaning. Fitted where corners were, if that is known, with the "
      "covariance carried over. Look at `refusal`: it says if the lenses differ by more than "
      "`max_difference_px` (0: 0.1 px).";
  m.def("fit_lens", &fit, py::arg("camera"), py::arg("model"), py::arg("max_difference_px") = 0.0,
        kDocumentation);
}

}  // namespace tagcal::python
