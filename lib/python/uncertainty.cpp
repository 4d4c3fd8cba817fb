#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>

#include "python/bindings.hpp"
#include "python/calibration.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/advice.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::python {
namespace {

using Samples = std::vector<Eigen::Vector2d>;

Samples sample_pixels(const ArrayLike& argument, const char* name) {
  const Rows2 rows(argument, name);
  constexpr std::size_t kMost = 1 << 20;  // numeric: each takes some 300 bytes
  if (rows.size() > kMost)
    throw Error(std::string(name) + ": must be at most 2^20 pixels, got " +
                std::to_string(rows.size()));
  return {rows.span().begin(), rows.span().end()};
}

Samples whole_image(const ImageSize& size) { return ImageGrid{size, 33, 21}.pixels(); }

// Samples of the region where corners were; of the whole image if that is not known.
Samples samples_of(const std::optional<ArrayLike>& argument, const CalibrationFile& known) {
  if (argument) return sample_pixels(*argument, "samples");
  return known.seen.hull().empty() ? whole_image(known.camera.image_size) : known.seen.samples();
}

// Throws Error unless the camera has a covariance.
UncertainCamera claim_of(const CalibrationFile& known, const char* name) {
  UncertainCamera claim = uncertain_camera(known);
  if (!claim.model)
    throw Error(std::string(name) +
                ": must have a covariance, as a Calibration or an UncertainCamera has");
  return claim;
}

ProjectionUncertainty projection_of(const CameraLike& camera, double distance_m,
                                    const std::optional<ImageGrid>& grid,
                                    const std::optional<ArrayLike>& samples) {
  const CalibrationFile known = known_camera(camera, "camera");
  const UncertainCamera claim = claim_of(known, "camera");
  check_distance(distance_m, "distance_m");
  const Samples pixels = samples_of(samples, known);
  const ImageGrid nodes = grid.value_or(ImageGrid{known.camera.image_size});
  py::gil_scoped_release release;
  return projection_uncertainty(claim, nodes, pixels, distance_m);
}

std::vector<WeakDirection> weak_directions_of(const CameraLike& camera,
                                              const std::optional<ArrayLike>& samples) {
  const CalibrationFile known = known_camera(camera, "camera");
  const UncertainCamera claim = claim_of(known, "camera");
  const Samples pixels = samples_of(samples, known);
  py::gil_scoped_release release;
  return weak_directions(claim, pixels);
}

std::optional<LensDifference> difference_of(const CameraLike& a, const CameraLike& b,
                                            double distance_m, bool is_whole_image,
                                            const std::optional<ArrayLike>& samples) {
  const CalibrationFile known_a = known_camera(a, "a"), known_b = known_camera(b, "b");
  check_distance(distance_m, "distance_m");
  if (is_whole_image && samples) throw Error("samples: give them or whole_image, not both");
  const Samples pixels =
      samples          ? sample_pixels(*samples, "samples")
      : is_whole_image ? whole_image(known_a.camera.image_size)
                       : common_samples(known_a.camera.image_size, known_a.seen, known_b.seen);
  py::gil_scoped_release release;
  return lens_difference(known_a.camera, known_b.camera, pixels, distance_m);
}

// (rows, columns, 2): u and v.
py::array_t<double> vectors_of(const LensDifference& d) {
  py::array_t<double> array({d.u_px.rows(), d.u_px.cols(), Eigen::Index{2}});
  double* out = array.mutable_data();
  for (Eigen::Index row = 0; row < d.u_px.rows(); ++row) {
    for (Eigen::Index column = 0; column < d.u_px.cols(); ++column) {
      *out++ = d.u_px(row, column);
      *out++ = d.v_px(row, column);
    }
  }
  return array;
}

void bind_difference(py::module_& m) {
  Record<LensDifference>(m, "LensDifference",
                         "How far two cameras project apart, less what a moved and rotated camera "
                         "explains.")
      .field("distance_m", &LensDifference::distance_m, "Of the points; may be infinite.")
      .field("rms_px", &LensDifference::rms_px, "Over the samples, sqrt(mean |d|^2).")
      .field("max_px", &LensDifference::max_px, "Largest over the samples.")
      .field("b_from_a", &LensDifference::b_from_a,
             "The motion that is subtracted, a Pose; at infinity a rotation.")
      .field("grid", &LensDifference::grid, "The nodes of the map.")
      .field("difference_px", &vectors_of,
             "(rows, columns, 2): the pixel by b minus that by a at the nodes of the grid; NaN if "
             "a or b has no value there.")
      .representation([](const LensDifference& d) {
        return distance_text(d.distance_m) + ": rms " + number(d.rms_px, 4) + " px, at most " +
               number(d.max_px, 4) + " px";
      });
  m.def("diff", &difference_of, py::arg("a"), py::arg("b"), py::arg("distance_m") = kInfinitelyFar,
        py::arg("whole_image") = false, py::arg("samples") = py::none(),
        "The difference of the projections of two cameras of one image size, of points at a "
        "distance. The camera b is moved to where it agrees best with a over the samples: pixels "
        "(N, 2) of a, by default where both had corners, or the whole image. None if fewer than "
        "six samples are visible in both.");
}

}  // namespace

void bind_uncertainty(py::module_& m) {
  m.def("projection_uncertainty", &projection_of, py::arg("camera"),
        py::arg("distance_m") = kInfinitelyFar, py::arg("grid") = py::none(),
        py::arg("samples") = py::none(),
        "The standard deviation of the projection over an image, of points at a distance. What a "
        "moved and rotated camera explains over the samples is subtracted: pixels (N, 2), three "
        "or more that are not on a line, by default where corners were.");
  m.def("weak_directions", &weak_directions_of, py::arg("camera"), py::arg("samples") = py::none(),
        "The at most three least determined combinations of parameters, by their effect on the "
        "projection at infinity over the samples (pixels (N, 2), by default where corners were), "
        "the largest first.");
  bind_difference(m);
  bind_advice(m);
  bind_lens_fit(m);
}

}  // namespace tagcal::python
