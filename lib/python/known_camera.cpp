#include <pybind11/pybind11.h>

#include "python/findings.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"

// Gathers what is known of a camera from the objects that have one.

namespace tagcal::python {

namespace py = pybind11;

std::optional<Camera> camera_of_answer(const Calibration& calibration) {
  if (!is_answer(calibration.status) || calibration.model == "weak") return std::nullopt;
  return calibration.camera;
}

CalibrationFile known_camera(const Calibration& calibration) {
  if (!is_answer(calibration.status))
    throw Error(refusal(calibration.status, calibration.findings));
  if (!camera_of_answer(calibration))
    throw Error("model weak has no camera for all views: each of them has its own scale");
  return calibration_file(calibration);
}

CalibrationFile known_camera(const CameraLike& argument, const char* name) {
  const std::string prefix = std::string(name) + ": ";
  if (py::isinstance<Camera>(argument)) {
    CalibrationFile known;
    known.camera = py::cast<const Camera&>(argument);
    return known;
  }
  if (py::isinstance<CalibrationFile>(argument)) return py::cast<const CalibrationFile&>(argument);
  if (!py::isinstance<Calibration>(argument))
    throw Error(prefix + "must be a Camera, an UncertainCamera or a Calibration, got " +
                type_name(argument));
  try {
    return known_camera(py::cast<const Calibration&>(argument));
  } catch (const Error& error) {
    throw Error(prefix + error.what());
  }
}

}  // namespace tagcal::python
