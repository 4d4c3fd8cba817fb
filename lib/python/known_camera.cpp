#include <pybind11/pybind11.h>

#include "python/findings.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"

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
  const std::optional<Camera> camera = camera_of_answer(calibration);
  if (!camera)
    throw Error("model weak has no camera for all views: each of them has its own scale");
  return {*camera,
          calibration.model,
          calibration.fixed,
          calibration.sigmas,
          calibration.covariance,
          calibration.seen,
          camera_error_px(calibration)};
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

LensOfModel lens_of_model(const CalibrationFile& known) {
  LensOfModel result{nullptr, {nullptr, known.camera.lens, {}}};
  if (known.covariance.size() == 0) return result;
  const LensType type = Model::named(known.model).lens_type();
  result.held = std::make_shared<const HeldModels>(known.fixed, type);
  result.lens.model = &result.held->named(known.model);
  result.lens.covariance = known.covariance;
  return result;
}

}  // namespace tagcal::python
