#include "tagcal/estimate/calibrate.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/bindings.hpp"
#include "python/calibration.hpp"
#include "python/dataset.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {
namespace {

using Fixed = std::map<std::string, double>;
using Distances = std::vector<double>;
using Times = std::vector<double>;

CalibrateOptions options_of(const std::string& model, double sigma_px, bool reject_outliers,
                            const std::optional<Camera>& start, double start_focal_px,
                            const Fixed& fixed, double tolerance_px, bool board_warp,
                            int max_iterations, int threads, const Distances& distances_m,
                            const Times& times_s) {
  not_negative(sigma_px, "sigma_px", "estimated");
  not_negative(start_focal_px, "start_focal_px", "none");
  not_negative(tolerance_px, "tolerance_px", "none");
  check_positive(max_iterations, "max_iterations");
  check_threads(threads);
  for (const double distance : distances_m) check_distance(distance, "distances_m");
  CalibrateOptions options;
  options.model = model;
  options.sigma_px = sigma_px;
  options.reject_outliers = reject_outliers;
  options.start = start;
  options.start_focal_px = start_focal_px;
  options.fixed = fixed;
  options.tolerance_px = tolerance_px;
  options.board_warp = board_warp;
  options.max_iterations = max_iterations;
  options.num_threads = static_cast<std::size_t>(threads);
  options.distances_m = distances_m;
  options.times_s = times_s;
  check_options(options);
  return options;
}

template <typename... Options>
Calibration of_dataset(const Dataset& dataset, const Options&... options) {
  const CalibrateOptions all = options_of(options...);
  py::gil_scoped_release release;
  return calibrate(dataset, all);
}

template <typename... Options>
Calibration of_points(const ArrayLike& object_points, const ArrayLike& image_points,
                      const ArrayLike& size, const Options&... options) {
  if (py::isinstance<Dataset>(object_points))
    throw Error("calibrate: after a Dataset and the model all arguments are named");
  const CalibrateOptions all = options_of(options...);
  const Dataset dataset = dataset_from_points(object_points, image_points, size, {});
  py::gil_scoped_release release;
  return calibrate(dataset, all);
}

constexpr const char* kDocumentation =
    "The camera and all poses of a data set, or of lists as cv2.calibrateCamera takes them "
    "(Dataset.from_points): bundle adjustment after a robust search, wrong corners rejected, with "
    "standard deviations, and a status that says if the data determine the camera.\n\n"
    "model: a name of model_names(), or \"auto\": the smallest that explains the data.\n"
    "sigma_px: noise of a corner per coordinate; 0: the corners' own covariances if they have "
    "them, else from the residuals.\n"
    "reject_outliers: False: all views and corners take part, except repeated views.\n"
    "start, start_focal_px: a Camera, or a focal length in pixels, to start from instead of a "
    "search.\n"
    "fixed: lens parameters to hold, by name: {\"cx\": 319.5}; \"f\" is fx and fy.\n"
    "tolerance_px: \"auto\" takes the smallest model whose projection differs from that of the "
    "best one by at most this, RMS where corners were.\n"
    "board_warp: raise Error unless there is one flat board, whose bend, twist and print are then "
    "estimated (as always).\n"
    "max_iterations: of each solve.\n"
    "threads: 0: one per core; the answer does not depend on it.\n"
    "distances_m: of further maps of the projection's uncertainty; the first two are at infinity "
    "and at the median distance of the corners.\n"
    "times_s: the time of each view of a film in seconds: estimates the readout of a rolling "
    "shutter.";

// `calibrate` with these arguments before the options.
template <typename Function, typename... Arguments>
void define(py::module_& m, const char* documentation, const Function& function,
            const Arguments&... arguments) {
  m.def("calibrate", function, arguments..., py::arg("model") = "auto", py::kw_only(),
        py::arg("sigma_px") = 0.0, py::arg("reject_outliers") = true, py::arg("start") = py::none(),
        py::arg("start_focal_px") = 0.0, py::arg("fixed") = Fixed(), py::arg("tolerance_px") = 0.0,
        py::arg("board_warp") = false, py::arg("max_iterations") = 100, py::arg("threads") = 1,
        py::arg("distances_m") = Distances(), py::arg("times_s") = Times(), documentation);
}

using Start = std::optional<Camera>;

}  // namespace

void bind_calibrate(py::module_& m) {
  bind_regions(m);
  bind_uncertain_camera(m);
  bind_calibration_parts(m);
  bind_calibration(m);
  define(m, kDocumentation,
         &of_dataset<std::string, double, bool, Start, double, Fixed, double, bool, int, int,
                     Distances, Times>,
         py::arg("dataset"));
  define(m, "The same of lists as cv2.calibrateCamera takes them.",
         &of_points<std::string, double, bool, Start, double, Fixed, double, bool, int, int,
                    Distances, Times>,
         py::arg("object_points"), py::arg("image_points"), py::arg("size"));
}

}  // namespace tagcal::python
