#include "tagcal/estimate/advice.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/calibration.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"

// The view to take next, the views that matter, and where the camera is.

namespace tagcal::python {
namespace {

// Throws Error unless the data set has the views of the calibration.
void check_calibrated(const Dataset& dataset, const Calibration& calibration) {
  for (const CalibratedView& view : calibration.views)
    if (view.view >= dataset.views.size() || dataset.views[view.view].image != view.image)
      throw Error("dataset: must be the one that was calibrated, view " +
                  std::to_string(view.view) + " differs");
}

std::optional<AdvisedView> advice(const Dataset& dataset, const Calibration& calibration) {
  check_calibrated(dataset, calibration);
  py::gil_scoped_release release;
  return advise(dataset, calibration);
}

ViewSelection selection(const Dataset& dataset, const Calibration& calibration, int count) {
  check_positive(count, "count");
  check_calibrated(dataset, calibration);
  py::gil_scoped_release release;
  return select_views(dataset, calibration, count);
}

void bind_advised_view(py::module_& m) {
  Record<AdvisedView>(m, "AdvisedView", "A view to take next.")
      .field("sentence", &AdvisedView::sentence, "The view and its effect.")
      .field("camera_from_board", &AdvisedView::camera_from_board, "Where the camera would be.")
      .field("tilt_rad", &AdvisedView::tilt_rad,
             "Between the board's normal and the line of sight.")
      .field("distance_m", &AdvisedView::distance_m, "Of the board's centre.")
      .field(
          "pixel", [](const AdvisedView& v) { return v.pixel; }, "(2,), of the board's centre.")
      .field("focal_sigma_now_px", &AdvisedView::focal_sigma_now_px,
             "Standard deviation of the focal length (the larger of fx and fy); infinite if it is "
             "not determined.")
      .field("focal_sigma_px", &AdvisedView::focal_sigma_px,
             "The same after this view, for the same noise.")
      .field("projection_px", &AdvisedView::projection_px,
             "Standard deviation of the projection at infinity after it, RMS over the image.")
      .field("fills", &AdvisedView::fills, "SeenRegion.missing_parts that it covers.")
      .representation([](const AdvisedView& v) { return v.sentence; });
  m.def("advise", &advice, py::arg("dataset"), py::arg("calibration"),
        "The view that would improve a calibration most: after it the projection at infinity has "
        "the least variance over the image. None without a camera, or if no candidate shows half "
        "of the board.");
}

void bind_selection(py::module_& m) {
  Record<SelectedView>(m, "SelectedView", "A view that was selected, and what it adds.")
      .field("view", &SelectedView::view, "Index in Dataset.views.")
      .field("image", &SelectedView::image, "The name of the picture; may be empty.")
      .field("num_corners", &SelectedView::num_corners, "That took part in the calibration.")
      .field("projection_px", &SelectedView::projection_px,
             "Standard deviation of the projection at infinity (RMS over the image) by this view "
             "and those before it; infinite as long as they do not determine all parameters.")
      .representation([](const SelectedView& v) {
        return std::to_string(v.view) + " \"" + v.image + "\" " + number(v.projection_px, 3) +
               " px";
      });
  Record<ViewSelection>(m, "ViewSelection", "The most informative views of a calibration.")
      .field("views", &ViewSelection::views, "In the order of selection.")
      .field("all_px", &ViewSelection::all_px, "The standard deviation by all views.")
      .representation([](const ViewSelection& s) {
        const double last = s.views.empty() ? kInfinitelyFar : s.views.back().projection_px;
        return std::to_string(s.views.size()) + " views: " + number(last, 3) +
               " px, all views: " + number(s.all_px, 3) + " px";
      });
  m.def("select_views", &selection, py::arg("dataset"), py::arg("calibration"), py::arg("count"),
        "The `count` most informative views of a calibration: each next one is the view after "
        "which the projection at infinity has the least variance over the image. Rejected views "
        "are not selected; none without a covariance. To calibrate from them: Dataset(d.size, "
        "d.target, [d.views[s.view] for s in selection.views]).");
}

void bind_camera_in_target(py::module_& m) {
  Record<CameraInTarget>(m, "CameraInTarget",
                         "Where the camera is in the target's frame, and where it looks.")
      .field(
          "position_m", [](const CameraInTarget& c) { return c.position_m; }, "(3,), metres.")
      .field("azimuth_rad", &CameraInTarget::azimuth_rad,
             "Of the optical axis about z of the target, from +x towards +y.")
      .field("elevation_rad", &CameraInTarget::elevation_rad,
             "Of the optical axis above the target's xy-plane, towards +z.")
      .field("roll_rad", &CameraInTarget::roll_rad,
             "Of the camera about the optical axis, clockwise as seen from behind it; 0 if z of "
             "the target is up in the image.")
      .field("gimbal_lock", &CameraInTarget::gimbal_lock,
             "True if the optical axis is along z of the target: azimuth and roll are one valid "
             "choice, and their covariances are NaN.")
      .field("covariance", &CameraInTarget::covariance,
             "(6, 6), of (position, azimuth, elevation, roll), by linearisation.")
      .representation([](const CameraInTarget& c) {
        const auto& x = c.position_m;
        return "at (" + number(x[0], 5) + ", " + number(x[1], 5) + ", " + number(x[2], 5) +
               ") m, azimuth " + number(c.azimuth_rad, 4) + ", elevation " +
               number(c.elevation_rad, 4) + ", roll " + number(c.roll_rad, 4) + " rad";
      });
  m.def("camera_in_target", &camera_in_target, py::arg("hypothesis"),
        "Where the camera of a pose is in the target's frame, with covariance: of "
        "`estimate.hypotheses[0]`.");
}

}  // namespace

void bind_advice(py::module_& m) {
  bind_advised_view(m);
  bind_selection(m);
  bind_camera_in_target(m);
}

}  // namespace tagcal::python
