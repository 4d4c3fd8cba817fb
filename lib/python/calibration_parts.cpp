#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/arrays.hpp"
#include "python/calibration.hpp"
#include "python/findings.hpp"
#include "python/records.hpp"

// Binds the parts of a Calibration.

namespace tagcal::python {
namespace {

template <typename T>
auto corner_of_id(const T& t) {
  return std::pair(t.id.tag_id, t.id.corner);
}

void bind_projection(py::module_& m) {
  Record<ProjectionUncertainty>(
      m, "ProjectionUncertainty",
      "Standard deviation of the projection (px per coordinate) over an image, of the points at "
      "one distance. What a moved and rotated camera explains is subtracted, because the pose "
      "absorbs it in any use of the lens.")
      .field("distance_m", &ProjectionUncertainty::distance_m, "Of the points; may be infinite.")
      .field("grid", &ProjectionUncertainty::grid, "The nodes of the map.")
      .field("sigma_px", &ProjectionUncertainty::sigma_px,
             "(rows, columns), at the nodes of the grid; NaN if a node has no ray.")
      .field("region_px", &ProjectionUncertainty::region_px,
             "RMS over the samples of the region; infinite without samples.")
      .field("region_max_px", &ProjectionUncertainty::region_max_px, "Largest over the samples.")
      .representation([](const ProjectionUncertainty& p) {
        return distance_text(p.distance_m) + ": rms " + number(p.region_px, 3) + " px";
      });
}

void bind_calibrated_view(py::module_& m) {
  Record<CalibratedView>(m, "CalibratedView", "The pose of one view of a calibration.")
      .field("image", &CalibratedView::image, "The name of the picture; may be empty.")
      .field("view", &CalibratedView::view, "Its index in Dataset.views.")
      .field("camera_from_world", &CalibratedView::camera_from_world,
             "The Pose. With model \"weak\" the point X projects to scale (R X + t) + centre of "
             "the image, and t_z is 0.")
      .field("covariance", &CalibratedView::covariance,
             "(6, 6), of (omega rad, tau m) in the camera frame: R <- exp(omega) R, t <- t + tau. "
             "With model \"weak\" that of t_z is NaN.")
      .field("num_corners", &CalibratedView::num_corners, "That take part.")
      .field(
          "residuals_px", [](const CalibratedView& v) { return array_of(v.residuals_px); },
          "(N, 2), projected - observed of each corner that takes part, in the order of the "
          "view's observations, without what the fit knows of the board's shape and of motion.")
      .field("rms_px", &CalibratedView::rms_px, "sqrt(sum |r|^2 / corners), of these.")
      .field("scale_px_per_m", &CalibratedView::scale_px_per_m, "With model \"weak\"; else None.")
      .field("scale_sigma_px_per_m", &CalibratedView::scale_sigma_px_per_m,
             "Standard deviation of the scale; NaN if it is not known, 0 without a scale.")
      .field("mirrored", &CalibratedView::mirrored,
             "With model \"weak\" and a plane: the second Pose, which fits as well; else None.")
      .representation([](const CalibratedView& v) {
        return "\"" + v.image + "\" " + std::to_string(v.num_corners) + " corners, rms " +
               number(v.rms_px, 3) + " px";
      });
}

void bind_outlier(py::module_& m) {
  Record<Outlier>(m, "Outlier", "A rejected corner.")
      .field("image", &Outlier::image, "The name of the picture; may be empty.")
      .field("id", &corner_of_id<Outlier>, "(tag, corner), as in View.ids.")
      .field("residual_px", &Outlier::residual_px,
             "Its distance from where the answer projects it; NaN if it is outside the lens' "
             "domain.")
      .field("view", &Outlier::view, "Index of the view in Dataset.views.")
      .field("corner", &Outlier::corner, "Index of the corner in View.pixels.")
      .representation([](const Outlier& o) {
        return "\"" + o.image + "\" (" + std::to_string(o.id.tag_id) + ", " +
               std::to_string(o.id.corner) + "), residual " + number(o.residual_px, 4) + " px";
      });
}

void bind_step(py::module_& m) {
  Record<ModelStep>(m, "ModelStep", "One model of the ladder in the choice of \"auto\".")
      .field("model", &ModelStep::model, "Its name.")
      .field("num_parameters", &ModelStep::num_parameters, "Its free parameters.")
      .field("cost", &ModelStep::cost,
             "Sum of squared (whitened) residuals, each up to the rejection bound.")
      .field("bic", &ModelStep::bic, "Bayesian information criterion.")
      .field("difference_px", &ModelStep::difference_px,
             "Difference of its projection from that of the model of lowest BIC, RMS over the "
             "seen region, less a motion of the camera. None if the two were not compared.")
      .field("weight", &ModelStep::weight, "In the claim.")
      .field("taken", &ModelStep::taken, "The answer, or a fit that the answer started from.")
      .field(
          "sentence", [](const ModelStep& s) { return in_python(s.sentence); }, "The reason.")
      .representation([](const ModelStep& s) { return s.model + ": " + in_python(s.sentence); });
}

void bind_halves(py::module_& m) {
  Record<HalvesCheck>(m, "HalvesCheck",
                      "Cross-validation: the lenses of two halves of the views, compared.")
      .field("distance_m", &HalvesCheck::distance_m, "At which they differ most; or infinity.")
      .field("difference_px", &HalvesCheck::difference_px,
             "Of their projections, less a motion of the camera: RMS per coordinate.")
      .field("predicted_px", &HalvesCheck::predicted_px, "Its standard deviation.")
      .field("ratio", &HalvesCheck::ratio, "difference_px / predicted_px, or of all parameters.")
      .field("disagree", &HalvesCheck::disagree,
             "True if the ratio exceeds 2, and chi-square of the parameters p = 0.001.")
      .field(
          "source",
          [](const HalvesCheck& h) {
            return h.source.empty() ? std::nullopt : std::optional(h.source);
          },
          "The source whose views are compared with the rest; None: every other view.")
      .representation([](const HalvesCheck& h) {
        return std::string(h.disagree ? "disagree" : "agree") + ", ratio " + number(h.ratio, 3);
      });
}

void bind_warp(py::module_& m) {
  Record<BoardWarp>(m, "BoardWarp",
                    "How a board differs from its file. A point at (x, y), with x' and y' from -1 "
                    "to 1 over the board, is out of its plane, towards the viewer, by bend[0] (1 - "
                    "x'^2) + bend[1] (1 - y'^2) + twist x' y', and at y (1 + aspect), from the "
                    "board's middle, instead of y.")
      .field(
          "bend_mm", [](const BoardWarp& w) { return w.bend_mm; }, "(2,), millimetres.")
      .field(
          "sigma_mm", [](const BoardWarp& w) { return w.sigma_mm; },
          "(2,): standard deviations of the bends.")
      .field("twist_mm", &BoardWarp::twist_mm, "Millimetres.")
      .field("sigma_twist_mm", &BoardWarp::sigma_twist_mm, "Its standard deviation.")
      .field("aspect", &BoardWarp::aspect,
             "The share by which the print is longer along y than its file says.")
      .field("sigma_aspect", &BoardWarp::sigma_aspect, "Its standard deviation.")
      .representation([](const BoardWarp& w) {
        return number(w.bend_mm.x(), 3) + " +- " + number(w.sigma_mm.x(), 2) + " mm in x, " +
               number(w.bend_mm.y(), 3) + " +- " + number(w.sigma_mm.y(), 2) + " mm in y";
      });
}

void bind_readout(py::module_& m) {
  Record<Readout>(m, "Readout",
                  "Of a rolling shutter: the time from the first row of a picture to the last.")
      .field("seconds", &Readout::seconds, "Negative if the last row comes first.")
      .field("sigma_s", &Readout::sigma_s, "Its standard deviation.")
      .field("num_views", &Readout::num_views, "The views whose neighbours in time show motion.")
      .field("is_seen", &Readout::is_seen,
             "It is significant: its motion is taken out of the corners.")
      .representation([](const Readout& r) {
        return number(1e3 * r.seconds, 4) + " +- " + number(1e3 * r.sigma_s, 2) + " ms";
      });
}

void bind_rest(py::module_& m) {
  Record<WeakDirection>(m, "WeakDirection", "A weakly determined combination of parameters.")
      .field("parameter", &WeakDirection::parameter,
             "The one with the largest effect on the projection.")
      .field("sigma_px", &WeakDirection::sigma_px,
             "Its effect on the projection at infinity, RMS over the seen region.")
      .field(
          "sentence", [](const WeakDirection& w) { return in_python(w.sentence); },
          "The parameters that are correlated, and a remedy.")
      .representation([](const WeakDirection& w) {
        return w.parameter + " " + number(w.sigma_px, 3) + " px: " + in_python(w.sentence);
      });
  Record<CalibrateSeconds>(m, "CalibrateSeconds", "Wall-clock times, seconds.")
      .field("start", &CalibrateSeconds::start, "Closed form and robust search.")
      .field("solve", &CalibrateSeconds::solve, "Bundle adjustment.")
      .field("covariance", &CalibrateSeconds::covariance, "Covariance and checks.")
      .field("total", &CalibrateSeconds::total, "All.")
      .representation([](const CalibrateSeconds& s) { return number(s.total, 3) + " s"; });
}

}  // namespace

void bind_calibration_parts(py::module_& m) {
  bind_projection(m);
  bind_calibrated_view(m);
  bind_outlier(m);
  bind_step(m);
  bind_halves(m);
  bind_warp(m);
  bind_readout(m);
  bind_rest(m);
}

}  // namespace tagcal::python
