#include "tagcal/estimate/lens_fit.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/calibration.hpp"
#include "python/camera.hpp"
#include "python/foreign_camera.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"

// A lens of one model that projects as a lens of another does; lenses of other tools as sources.

namespace tagcal::python {
namespace {

template <typename Lens>
Lens lens_of(const std::map<std::string, double>& values) {
  typename Lens::Parameters parameters{};
  std::string names;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string name(Lens::kParameterNames[i]);
    names += (i > 0 ? ", " : "") + name;
    const auto value = values.find(name);
    parameters[i] = value == values.end() ? std::nan("") : value->second;
    if (value != values.end() && !std::isfinite(value->second))
      throw Error("parameters: " + name + " must be finite, got " + number(value->second));
  }
  for (const double value : parameters)
    if (std::isnan(value) || values.size() != parameters.size())
      throw Error("parameters: must be " + names + " of a lens \"" + std::string(Lens::kName) +
                  "\"");
  return Lens(parameters);
}

ForeignCamera foreign_camera(const std::string& lens, const std::map<std::string, double>& values,
                             const ArrayLike& size) {
  const ImageSize image_size = size_of_argument(size, "size");
  if (lens == DoubleSphere::kName) return {lens_of<DoubleSphere>(values), image_size};
  if (lens == ExtendedUnified::kName) return {lens_of<ExtendedUnified>(values), image_size};
  if (lens == Unified::kName) return {lens_of<Unified>(values), image_size};
  throw Error("lens: must be \"double sphere\", \"extended unified\" or \"unified\", got \"" +
              lens + "\"");
}

std::map<std::string, double> values_of_foreign(const ForeignCamera& camera) {
  std::map<std::string, double> values;
  const auto names = parameter_names(camera.lens);
  for (std::size_t i = 0; i < names.size(); ++i)
    values.emplace(names[i], parameters(camera.lens)[i]);
  return values;
}

py::array_t<double> project_by_foreign(const ForeignCamera& camera, const ArrayLike& points) {
  const Rows3 rows(points, "points", Rows3::Check::none);
  std::vector<Eigen::Vector2d> pixels(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto pixel = rows[i].allFinite() ? project(camera.lens, rows[i]) : std::nullopt;
    pixels[i] = pixel.value_or(Eigen::Vector2d::Constant(std::nan("")));
  }
  py::array_t<double> array = array_of(std::span<const Eigen::Vector2d>(pixels));
  if (rows.is_single()) return array.reshape({2});
  return array;
}

py::array_t<double> unproject_by_foreign(const ForeignCamera& camera, const ArrayLike& pixels) {
  const Rows2 rows(pixels, "pixels", Rows2::Check::none);
  std::vector<Eigen::Vector3d> directions(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto ray = rows[i].allFinite() ? ray_in_camera(camera.lens, rows[i]) : std::nullopt;
    directions[i] = ray ? ray->direction : Eigen::Vector3d::Constant(std::nan(""));
  }
  py::array_t<double> array = array_of(std::span<const Eigen::Vector3d>(directions));
  if (rows.is_single()) return array.reshape({3});
  return array;
}

LensFit fit_source(const LensFitSource& source, const std::string& model,
                   double max_difference_px) {
  if (!(max_difference_px >= 0 && std::isfinite(max_difference_px)))
    throw Error("max_difference_px: must be >= 0 (0: 0.1 px), got " + number(max_difference_px));
  const Model& named = Model::named(model);
  py::gil_scoped_release release;
  return fit_lens(source, named, {max_difference_px});
}

LensFit fit_known(const CameraLike& camera, const std::string& model, double max_difference_px) {
  const CalibrationFile known = known_camera(camera, "camera");
  const UncertainLens claim = uncertain_lens(known);
  LensFitSource source{{claim.lens, known.camera.image_size}, {}, claim.covariance, known.seen};
  if (claim.model) source.free = claim.model->free();
  return fit_source(source, model, max_difference_px);
}

LensFit fit_foreign(const ForeignCamera& camera, const std::string& model,
                    double max_difference_px) {
  return fit_source({{camera.lens, camera.image_size}, {}, {}, {}}, model, max_difference_px);
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

void bind_foreign_camera(py::module_& m) {
  Record<ForeignCamera>(m, "ForeignCamera",
                        "A camera with a lens of other tools, which tagcal does not estimate: "
                        "`fit_lens` finds one of tagcal's that projects alike.")
      .field(
          "lens", [](const ForeignCamera& c) { return std::string(lens_name(c.lens)); },
          "\"double sphere\", \"extended unified\" or \"unified\".")
      .field("parameters", &values_of_foreign, "The lens parameters by name.")
      .field(
          "size",
          [](const ForeignCamera& c) { return std::pair(c.image_size.width, c.image_size.height); },
          "(width, height), pixels.")
      .representation([](const ForeignCamera& c) {
        std::string text = std::string(lens_name(c.lens)) + " " +
                           std::to_string(c.image_size.width) + " x " +
                           std::to_string(c.image_size.height);
        for (std::size_t i = 0; i < parameters(c.lens).size(); ++i)
          text += " " + std::string(parameter_names(c.lens)[i]) + "=" +
                  number(parameters(c.lens)[i], 7);
        return text;
      })
      .def(py::init(&foreign_camera), py::arg("lens"), py::arg("parameters"), py::arg("size"),
           "`lens`: \"double sphere\" (fx, fy, cx, cy, xi, alpha), \"extended unified\" (fx, fy, "
           "cx, cy, alpha, beta) or \"unified\" (fx, fy, cx, cy, alpha).")
      .def("project", &project_by_foreign, py::arg("points"),
           "The pixels (N, 2) of points (N, 3) in the camera frame; NaN outside the lens' domain.")
      .def("unproject", &unproject_by_foreign, py::arg("pixels"),
           "The unit directions (N, 3) of the rays of pixels (N, 2); NaN where there is none.");
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
          "difference_px", [](const LensFit& f) { return matrix_array(f.difference_px); },
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
  bind_foreign_camera(m);
  bind_fit(m);
  constexpr const char* kDocumentation =
      "The lens of a model that projects as that of the camera does, in the same frame: poses and "
      "pixels keep their meaning. Fitted where corners were, if that is known, with the "
      "covariance carried over. Look at `refusal`: it says if the lenses differ by more than "
      "`max_difference_px` (0: 0.1 px).";
  m.def("fit_lens", &fit_foreign, py::arg("camera"), py::arg("model"),
        py::arg("max_difference_px") = 0.0, kDocumentation);
  m.def("fit_lens", &fit_known, py::arg("camera"), py::arg("model"),
        py::arg("max_difference_px") = 0.0, kDocumentation);
}

}  // namespace tagcal::python
