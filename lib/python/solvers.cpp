#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "tagcal/error.hpp"
#include "tagcal/solvers/n_point.hpp"
#include "tagcal/solvers/p3p.hpp"
#include "tagcal/solvers/p4pf.hpp"
#include "tagcal/solvers/plane.hpp"
#include "tagcal/solvers/weak_perspective.hpp"

namespace tagcal::python {
namespace {

void check_rows(std::size_t rows, const char* name, std::size_t wanted, bool or_more) {
  if (or_more ? rows < wanted : rows != wanted)
    throw Error(std::string(name) + ": must have " + std::to_string(wanted) + " rows" +
                (or_more ? " or more" : "") + ", got " + std::to_string(rows));
}

template <typename T, std::size_t N>
std::vector<T> list(const Solutions<T, N>& solutions) {
  return {solutions.begin(), solutions.end()};
}

std::vector<std::pair<Pose, double>> with_focal(const Solutions<PoseAndFocal, 6>& solutions) {
  std::vector<std::pair<Pose, double>> result;
  for (const PoseAndFocal& s : solutions) result.emplace_back(s.camera_from_target, s.focal_px);
  return result;
}

std::vector<Pose> three_points(const ArrayLike& points, const ArrayLike& rays) {
  const Rows3 x(points, "points");
  const Rows3 directions(rays, "rays");
  check_rows(x.size(), "points", 3, false);
  check_rows(directions.size(), "rays", 3, false);
  return list(p3p(x.span().first<3>(), directions.span().first<3>()));
}

std::vector<std::pair<Pose, double>> four_points(const ArrayLike& points, const ArrayLike& pixels) {
  const Rows3 x(points, "points");
  const Rows2 p(pixels, "pixels_from_centre");
  check_rows(x.size(), "points", 4, false);
  check_rows(p.size(), "pixels_from_centre", 4, false);
  return with_focal(p4pf(x.span().first<4>(), p.span().first<4>()));
}

std::vector<Pose> n_points(const ArrayLike& points, const ArrayLike& rays) {
  const Rows3 x(points, "points");
  const Rows3 directions(rays, "rays");
  check_rows(x.size(), "points", 3, true);
  check_same_length(x.size(), "points", directions.size(), "rays");
  py::gil_scoped_release release;
  return list(pnp(x.span(), directions.span()));
}

std::optional<Eigen::Matrix3d> plane_homography(const ArrayLike& points, const ArrayLike& rays) {
  const Rows2 x(points, "points");
  const Rows3 directions(rays, "rays");
  check_rows(x.size(), "points", 4, true);
  check_same_length(x.size(), "points", directions.size(), "rays");
  py::gil_scoped_release release;
  return homography(x.span(), directions.span());
}

std::optional<std::pair<Pose, double>> plane_with_focal(const ArrayLike& points,
                                                        const ArrayLike& pixels) {
  const Rows2 x(points, "points");
  const Rows2 p(pixels, "pixels_from_centre");
  check_rows(x.size(), "points", 4, true);
  check_same_length(x.size(), "points", p.size(), "pixels_from_centre");
  py::gil_scoped_release release;
  const auto found = plane_pose_and_focal(x.span(), p.span());
  if (!found) return std::nullopt;
  return std::pair(found->camera_from_target, found->focal_px);
}

std::vector<std::pair<Pose, double>> weak_perspective(const ArrayLike& points,
                                                      const ArrayLike& pixels) {
  const Rows3 x(points, "points");
  const Rows2 p(pixels, "pixels_from_centre");
  check_same_length(x.size(), "points", p.size(), "pixels_from_centre");
  std::vector<std::pair<Pose, double>> result;
  for (const WeakPerspectivePose& pose : weak_perspective_poses(x.span(), p.span()))
    result.emplace_back(pose.camera_from_target, pose.scale_px_per_m);
  return result;
}

}  // namespace

void bind_solvers(py::module_& m) {
  m.def("p3p", &three_points, py::arg("points"), py::arg("rays"),
        "Up to four poses camera_from_target of three points (3, 3), metres, with known rays (3, "
        "3), directions in the camera frame of any length (Camera.unproject).");
  m.def("p4pf", &four_points, py::arg("points"), py::arg("pixels_from_centre"),
        "Up to six pairs of a pose and a focal length (px) of four points in space (4, 3), not in "
        "a plane, with pixels (4, 2) relative to the principal point of a pinhole with square "
        "pixels.");
  m.def("pnp", &n_points, py::arg("points"), py::arg("rays"),
        "Poses of three points (N, 3) or more in any configuration but a line, with rays (N, 3): "
        "the minima of the object-space error, best first.");
  m.def("homography", &plane_homography, py::arg("points"), py::arg("rays"),
        "H (3, 3) with ray ~ H (X, Y, 1), of four points (N, 2) of a plane or more; None if they "
        "do not determine it.");
  m.def(
      "ippe", [](const ArrayLike& h) { return list(ippe(matrix3(h, "camera_from_plane"))); },
      py::arg("camera_from_plane"),
      "Both poses of a plane from its homography to rays (Collins & Bartoli 2014); they agree with "
      "it at the origin of the plane.");
  m.def("plane_pose_and_focal", &plane_with_focal, py::arg("points"), py::arg("pixels_from_centre"),
        "A pose and a focal length (px) of four points (N, 2) of a tilted plane or more, with "
        "pixels relative to the principal point; None if they do not determine it.");
  m.def("weak_perspective_poses", &weak_perspective, py::arg("points"),
        py::arg("pixels_from_centre"),
        "Pairs of a pose and a scale (px per m) of a scaled orthographic camera, best first; two "
        "for a plane.");
}

}  // namespace tagcal::python
