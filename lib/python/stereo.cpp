#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/reproject/rectify.hpp"
#include "tagcal/uncertainty/triangulate.hpp"

// Pairs of cameras of a rig, rectified, and points by several of them.

namespace tagcal::python {
namespace {

void need_pinholes(const RectifiedPair& pair, const char* name) {
  if (!std::holds_alternative<Camera>(pair.targets[0]))
    throw Error(std::string(name) + ": of pinholes only, not of longlat");
}

RectifiedPair rectify_cameras(const KnownRig& rig, std::size_t first, std::size_t second,
                              const std::optional<double>& alpha, bool zero_disparity,
                              bool longlat) {
  py::gil_scoped_release release;
  return rectify(rig, first, second, {alpha, zero_disparity, longlat});
}

VerticalDisparity disparity_of(const KnownRig& rig, const RectifiedPair& pair,
                               const ArrayLike& first, const ArrayLike& second, double sigma_px) {
  const Matrix2 covariance = sigma_px * sigma_px * Matrix2::Identity();
  const auto found = vertical_disparity(rig, pair,
                                        {UncertainPixel{vector2(first, "first"), covariance},
                                         UncertainPixel{vector2(second, "second"), covariance}});
  if (!found) throw Error("vertical_disparity: a pixel has no place in the rectified picture");
  return *found;
}

using PixelOrNone = std::optional<ArrayLike>;

TriangulatedPoint triangulate_pixels(const KnownRig& rig, const std::vector<PixelOrNone>& pixels,
                                     double sigma_px) {
  if (pixels.size() != rig.cameras.size())
    throw Error("pixels: must have " + std::to_string(rig.cameras.size()) +
                " items, one a camera, got " + std::to_string(pixels.size()));
  if (!(sigma_px > 0 && sigma_px < 1e6))
    throw Error("sigma_px: must be > 0, got " + number(sigma_px));
  std::vector<SeenPixel> seen;
  for (std::size_t c = 0; c < pixels.size(); ++c)
    if (pixels[c] && !pixels[c]->is_none())
      seen.push_back(
          {c, {vector2(*pixels[c], "pixels"), sigma_px * sigma_px * Matrix2::Identity()}});
  return triangulate(rig, seen);
}

// As cv::stereoRectify has them.
void add_matrices(Record<RectifiedPair>& pair) {
  pair.field(
      "R",
      [](const RectifiedPair& p) {
        return std::pair<Eigen::Matrix3d, Eigen::Matrix3d>(
            p.camera_from_rectified[0].rotation_matrix().transpose(),
            p.camera_from_rectified[1].rotation_matrix().transpose());
      },
      "R1 and R2 of cv2.stereoRectify.");
  pair.field(
      "P",
      [](const RectifiedPair& p) {
        need_pinholes(p, "P");
        using P = Eigen::Matrix<double, 3, 4>;
        return std::pair<P, P>(projection_matrix(p, 0), projection_matrix(p, 1));
      },
      "P1 and P2 of cv2.stereoRectify. Raises Error with longlat.");
  pair.field(
      "Q",
      [](const RectifiedPair& p) {
        need_pinholes(p, "Q");
        return Eigen::Matrix4d(disparity_to_depth(p));
      },
      "(4, 4), for cv2.reprojectImageTo3D. Raises Error with longlat.");
}

void bind_pair(py::module_& m) {
  Record<RectifiedPair> pair(m, "RectifiedPair",
                             "Two cameras of a rig as they would see if their epipolar lines were "
                             "equal rows (columns, if is_vertical).");
  pair.field("cameras", &RectifiedPair::cameras, "Their indices in the rig.");
  pair.field("is_vertical", &RectifiedPair::is_vertical,
             "The baseline is along y, and epipolar lines are columns.");
  pair.field("targets", &RectifiedPair::targets,
             "Two pinholes (Camera), or two Panorama with longlat: `target` of `reproject` and "
             "`pixel_map`.");
  pair.field("camera_from_rectified", &RectifiedPair::camera_from_rectified,
             "Two rotations (Pose): `camera_from_target` of `reproject` and `pixel_map`.");
  pair.field("translation_m", &RectifiedPair::translation_m,
             "Of the second camera's frame along the baseline; negative if it is right of (below) "
             "the first one.");
  add_matrices(pair);
  pair.representation([](const RectifiedPair& p) {
    const ImageSize size = size_of(p.targets[0]);
    return "cameras " + std::to_string(p.cameras[0]) + " and " + std::to_string(p.cameras[1]) +
           ", " + size_text(size) + ", baseline " + number(std::abs(p.translation_m), 5) + " m";
  });
}

void bind_disparity(py::module_& m) {
  Record<VerticalDisparity> disparity(m, "VerticalDisparity",
                                      "How far the rectified rows of one point differ.");
  disparity.field("difference_px", &VerticalDisparity::difference_px, "Row of the first - second.");
  disparity.field("sigma_px", &VerticalDisparity::sigma_px,
                  "Its standard deviation, by the pixels and the rig.");
  disparity.field("sigma_of_rig_px", &VerticalDisparity::sigma_of_rig_px,
                  "The part of the places and lenses of the cameras.");
}

void bind_points(py::module_& m) {
  Record<TriangulatedPoint> point(m, "TriangulatedPoint", "A point that cameras of a rig see.");
  point.field(
      "status", &TriangulatedPoint::status,
      "\"ok\"; \"few_cameras\", \"no_ray\", \"far\" (the distance has no bound) or \"behind\" a "
      "camera: there is no point.");
  point.field(
      "x",
      [](const TriangulatedPoint& p) -> std::optional<Eigen::Vector3d> {
        if (p.status != TriangulationStatus::ok) return std::nullopt;
        return p.point.x;
      },
      "(3,), metres, in the rig's frame; None without a point.");
  point.field(
      "covariance",
      [](const TriangulatedPoint& p) -> std::optional<Eigen::Matrix3d> {
        if (p.status != TriangulationStatus::ok) return std::nullopt;
        return p.point.covariance;
      },
      "(3, 3), m^2: by the pixels, and by places and lenses of the cameras.");
  point.field("rms_px", &TriangulatedPoint::rms_px, "sqrt(sum |r|^2 / pixels).");
  point.field("chi_square", &TriangulatedPoint::chi_square,
              "Squared residuals over their covariance, of 2 n - 3 degrees of freedom.");
  point.field("contradicting", &TriangulatedPoint::contradicting,
              "Pixels that contradict the others: their indices among those that are given.");
  point.representation([](const TriangulatedPoint& p) {
    return std::string(status_name(p.status)) + ", rms " + number(p.rms_px, 3) + " px";
  });
}

}  // namespace

void bind_stereo(py::module_& m) {
  bind_pair(m);
  bind_disparity(m);
  bind_points(m);
  m.def("rectify", &rectify_cameras, py::arg("rig"), py::arg("first") = 0, py::arg("second") = 1,
        py::kw_only(), py::arg("alpha") = py::none(), py::arg("zero_disparity") = true,
        py::arg("longlat") = false,
        "Two cameras of a KnownRig (by index) with equal epipolar lines, as cv2.stereoRectify, for "
        "all lenses.\n\n"
        "alpha: 0: only pixels that the cameras see, to 1: all that they see; None: their focal "
        "length.\n"
        "longlat: panoramas, whose rows are angles about the baseline, for wide lenses.");
  m.def("vertical_disparity", &disparity_of, py::arg("rig"), py::arg("pair"), py::arg("first"),
        py::arg("second"), py::arg("sigma_px") = 0.0,
        "By how much the rows of a point differ that the two cameras see at the pixels `first` and "
        "`second` (2,) of noise sigma_px.");
  m.def("triangulate", &triangulate_pixels, py::arg("rig"), py::arg("pixels"),
        py::arg("sigma_px") = 0.5,
        "The point that cameras of a KnownRig see at `pixels`: (2,) or None for each camera. "
        "sigma_px: noise of the pixels.");
}

}  // namespace tagcal::python
