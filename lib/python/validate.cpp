#include "tagcal/validate/validate.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "python/bindings.hpp"
#include "python/calibration.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {
namespace {

Validation validation(const CameraLike& camera, const Dataset& dataset) {
  const CalibrationFile known = known_camera(camera, "camera");
  if (known.camera.image_size != dataset.image_size)
    throw Error("camera: must have the image size of the data set");
  py::gil_scoped_release release;
  return validate(known.camera, known.sigmas, dataset, known.camera_error_px);
}

void bind_parameter_error(py::module_& m) {
  Record<ParameterError>(m, "ParameterError", "One parameter compared with the truth.")
      .field("name", &ParameterError::name, "fx, fy, cx, cy, k1, ..")
      .field("estimate", &ParameterError::estimate, "Of the camera.")
      .field("truth", &ParameterError::truth, "Of the data set.")
      .field("sigma", &ParameterError::sigma, "Standard deviation; 0: held; None: not known.")
      .field("in_sigmas", &ParameterError::in_sigmas,
             "(estimate - truth) / sigma, if sigma is above 0.")
      .representation([](const ParameterError& p) {
        return p.name + " " + number(p.estimate, 8) + ", truth " + number(p.truth, 8) + ", " +
               (p.in_sigmas ? number(*p.in_sigmas, 3) + " sd off" : "not estimated");
      });
}

}  // namespace

void bind_validate(py::module_& m) {
  bind_parameter_error(m);
  Record<Validation>(m, "Validation", "A camera against OpenCV's projection and the truth.")
      .field("opencv_agrees", &Validation::opencv_agrees,
             "True if all differences are within their bounds, and there are some.")
      .field("max_projection_difference_px", &Validation::max_projection_difference_px,
             "Our projection against cv2.projectPoints or cv2.fisheye.projectPoints, over all "
             "corners.")
      .field("bound_px", &Validation::bound_px, "For that difference.")
      .field("max_jacobian_difference", &Validation::max_jacobian_difference,
             "Relative to the largest entry of the column.")
      .field("num_compared", &Validation::num_compared, "Corners.")
      .field("num_outside_domain", &Validation::num_outside_domain, "Corners, not compared.")
      .field("rms_px", &Validation::rms_px,
             "Of the corners, with poses estimated for the given camera.")
      .field("num_views", &Validation::num_views, "With a pose.")
      .field("num_without_pose", &Validation::num_without_pose, "Views without a pose.")
      .field("parameters", &Validation::parameters,
             "Against the truth, if it is known and has the same kind of lens.")
      .field("num_beyond_truth", &Validation::num_beyond_truth,
             "Parameters whose error exceeds 5 standard deviations; None if none has one.")
      .field("warnings", &Validation::warnings, "Sentences.")
      .representation([](const Validation& v) {
        std::string text = v.opencv_agrees       ? "OpenCV agrees"
                           : v.num_compared == 0 ? "OpenCV: nothing to compare"
                                                 : "OpenCV DISAGREES";
        text +=
            ", rms " + number(v.rms_px, 4) + " px over " + std::to_string(v.num_views) + " views";
        if (v.num_beyond_truth)
          text += (*v.num_beyond_truth == 0
                       ? ", no parameter"
                       : ", " + std::to_string(*v.num_beyond_truth) + " of the parameters") +
                  std::string(" beyond 5 sd of the truth");
        return text;
      });
  m.def("validate", &validation, py::arg("camera"), py::arg("dataset"),
        "Compares a camera with OpenCV's projection and, if the data set has it, with the truth. "
        "The pose of each view is estimated with the camera. Standard deviations come from a "
        "Calibration or an UncertainCamera.");
}

}  // namespace tagcal::python
