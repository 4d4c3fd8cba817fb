#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/bindings.hpp"
#include "python/dataset.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/check_camera.hpp"

// Is a calibration still valid?

namespace tagcal::python {
namespace {

CheckOptions check_options(double limit_px, int threads) {
  if (threads < 0)
    throw Error("threads: must be >= 0 (0: one per core), got " + std::to_string(threads));
  CheckOptions options;
  options.limit_px = limit_px;
  options.num_threads = static_cast<std::size_t>(threads);
  return options;
}

CameraCheck check_dataset(const Dataset& dataset, const CameraLike& camera, double limit_px,
                          int threads) {
  const UncertainCamera known = uncertain_camera(known_camera(camera, "camera"));
  const CheckOptions options = check_options(limit_px, threads);
  py::gil_scoped_release release;
  return check_camera(dataset, known, options);
}

CameraCheck check_datasets(const std::vector<Dataset>& datasets, const KnownRig& rig,
                           const std::string& pair, const TimesByCamera& times_s,
                           double tolerance_s, double limit_px, int threads) {
  const CheckOptions options = check_options(limit_px, threads);
  if (datasets.size() != rig.cameras.size())
    throw Error("datasets: must have " + std::to_string(rig.cameras.size()) +
                " items, one a camera, got " + std::to_string(datasets.size()));
  std::vector<std::string> names;
  for (const KnownRig::Member& member : rig.cameras) names.push_back(member.name);
  py::gil_scoped_release release;
  return check_rig(rig_dataset(datasets, names, pair, times_s, tolerance_s), rig, options);
}

void bind_changes(py::module_& m) {
  Record<ParameterChange> parameter(m, "ParameterChange", "A parameter now less what is known.");
  parameter.field("name", &ParameterChange::name,
                  "fx, cx, k1, ..; of a place rx, ry, rz (rad), tx, ty, tz (m).");
  parameter.field("known", &ParameterChange::known, "What the camera says; 0 of a place.");
  parameter.field("change", &ParameterChange::change, "Now less that.");
  parameter.field("sigma", &ParameterChange::sigma, "Its standard deviation.");
  parameter.representation([](const ParameterChange& p) {
    return p.name + " " + number(p.change) + " +- " + number(p.sigma, 2);
  });
  Record<CameraChange> change(m, "CameraChange", "The leanest change that explains the pictures.");
  change.field("camera", &CameraChange::camera, "Index in the rig; 0 for one camera.");
  change.field("kind", &CameraChange::kind,
               "\"focal length\", \"principal point\", \"focal length and principal point\", "
               "\"place in the rig\" or \"lens\".");
  change.field("parameters", &CameraChange::parameters, "A list of ParameterChange.");
  change.field("rms_px", &CameraChange::rms_px, "In the image where the pictures have corners.");
  change.field("max_px", &CameraChange::max_px, "The largest there.");
  change.field(
      "as_well",
      [](const CameraChange& c) {
        std::vector<std::pair<std::size_t, std::string>> others;
        for (const ChangedPart& other : c.as_well)
          others.emplace_back(other.camera, kind_name(other.kind));
        return others;
      },
      "Other changes that also explain the pictures: (camera, kind) of each.");
  change.representation([](const CameraChange& c) {
    return std::string(kind_name(c.kind)) + ", " + number(c.max_px, 2) + " px at most";
  });
  Record<DetectableChange> detectable(m, "DetectableChange",
                                      "The smallest change that the pictures would have shown.");
  detectable.field("camera", &DetectableChange::camera, "Index in the rig.");
  detectable.field("kind", &DetectableChange::kind, "As of a CameraChange.");
  detectable.field("max_px", &DetectableChange::max_px, "In the image at most.");
  detectable.field("without_scale_px", &DetectableChange::without_scale_px,
                   "The same without a change of all lengths alike, as another print of the board "
                   "makes.");
  detectable.field("size", &DetectableChange::size,
                   "px of the focal length or the principal point, mm of a place; else 0.");
  detectable.field("step", &DetectableChange::step,
                   "The change itself, with either sign: of the free parameters of the lens, or "
                   "(omega rad, tau m) of a place.");
  detectable.representation([](const DetectableChange& d) {
    return std::string(kind_name(d.kind)) + ", " + number(d.max_px, 2) + " px";
  });
}

void bind_answer_of_check(py::module_& m) {
  Record<CheckedCamera> camera(m, "CheckedCamera", "A camera of a check.");
  camera.field("name", &CheckedCamera::name, "Its name.");
  camera.field("num_views", &CheckedCamera::num_views, "That take part.");
  camera.field("num_corners", &CheckedCamera::num_corners, "That take part.");
  camera.field("sigma_px", &CheckedCamera::sigma_px, "Noise that the residuals show.");
  camera.field("rms_px", &CheckedCamera::rms_px, "Of the residuals, with the camera free.");
  camera.field("known_rms_px", &CheckedCamera::known_rms_px,
               "With the camera as it was calibrated, and the poses free.");
  camera.representation([](const CheckedCamera& c) {
    return "\"" + c.name + "\" " + counted(static_cast<std::size_t>(c.num_views), "view");
  });
  Record<CameraCheck> check(m, "CameraCheck", "Whether a calibration is still valid.");
  check.field("verdict", &CameraCheck::verdict, "\"valid\", \"changed\" or \"cannot_tell\".");
  check.field("in_sigmas", &CameraCheck::in_sigmas,
              "Normal score of the likelihood ratio: 0 +- 1 if nothing changed.");
  check.field("false_alarm", &CameraCheck::false_alarm,
              "Probability of \"changed\" if nothing changed.");
  check.field("power", &CameraCheck::power, "Probability with which `detectable` is found.");
  check.field("change", &CameraCheck::change,
              "CameraChange; None unless \"changed\", and if no single kind explains it.");
  check.field("detectable", &CameraCheck::detectable, "A list of DetectableChange.");
  check.field("smallest_px", &CameraCheck::smallest_px,
              "The largest max_px of them but for the whole lens.");
  check.field("cameras", &CameraCheck::cameras, "A list of CheckedCamera.");
  check.field("findings", &CameraCheck::findings, "What the check found out about its data.");
  check.representation([](const CameraCheck& c) {
    return std::string(verdict_name(c.verdict)) + ", score " + number(c.in_sigmas, 2);
  });
}

}  // namespace

void bind_check(py::module_& m) {
  bind_changes(m);
  bind_answer_of_check(m);
  m.def("check_camera", &check_dataset, py::arg("dataset"), py::arg("camera"), py::kw_only(),
        py::arg("limit_px") = 1.0, py::arg("threads") = 1,
        "If a calibration is still valid: the corners of new pictures against a camera.\n\n"
        "camera: a Camera (taken as exact), an UncertainCamera or a Calibration.\n"
        "limit_px: the change that matters, in the image; \"valid\" says that a smaller one would "
        "have shown.\n"
        "threads: 0: one per core; the answer does not depend on it.");
  m.def("check_rig", &check_datasets, py::arg("datasets"), py::arg("rig"), py::kw_only(),
        py::arg("pair") = "name", py::arg("times_s") = py::none(), py::arg("tolerance_s") = 0.005,
        py::arg("limit_px") = 1.0, py::arg("threads") = 1,
        "The same for a KnownRig and the places of its cameras, from one Dataset a camera in the "
        "order of the rig. pair, times_s, tolerance_s: as of `calibrate_rig`.");
}

}  // namespace tagcal::python
