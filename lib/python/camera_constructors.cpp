#include <pybind11/pybind11.h>

#include <algorithm>
#include <cmath>

#include "python/arrays.hpp"
#include "python/camera.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {

ImageSize size_of_argument(py::handle argument, const char* name) {
  Eigen::Vector2d size;
  read_matrix(argument, name, {size.data(), 2}, 2, 0);
  constexpr double kLargest = 1 << 24;  // numeric: a side; its square fits into 64 bits
  for (const double side : size)
    if (!(side >= 1 && side <= kLargest && side == std::floor(side)))
      throw Error(std::string(name) + ": must be (width, height), whole numbers > 0, got (" +
                  number(size[0]) + ", " + number(size[1]) + ")");
  return {static_cast<int>(size[0]), static_cast<int>(size[1])};
}

namespace {

// OpenCV's order in our parameters: k1 k2 p1 p2 k3 k4 k5 k6 follow fx fy cx cy in both lenses.
template <typename Lens>
Camera camera_with_distortion(double fx, double fy, double cx, double cy, const ArrayLike& size,
                              const ArrayLike& distortion) {
  typename Lens::Parameters parameters{fx, fy, cx, cy};
  if (distortion.is_none()) return {Lens(parameters), size_of_argument(size, "size")};
  const py::array_t<double> coefficients = real_array(distortion, "distortion");
  const bool is_list =
      coefficients.ndim() == 1 ||  // OpenCV returns (1, N) or (N, 1)
      (coefficients.ndim() == 2 && (coefficients.shape(0) == 1 || coefficients.shape(1) == 1));
  constexpr py::ssize_t kMost = Lens::kNumParameters - 4;
  // OpenCV's rational model comes with six zeros of thin prisms and a tilted sensor.
  const auto count = std::min<py::ssize_t>(coefficients.size(), kMost);
  if (!is_list ||
      std::any_of(coefficients.data() + count, coefficients.data() + coefficients.size(),
                  [](double value) { return value != 0; }))
    throw Error("distortion: must be a list of at most " + std::to_string(kMost) + " numbers");
  std::copy_n(coefficients.data(), count, parameters.begin() + 4);
  return {Lens(parameters), size_of_argument(size, "size")};
}

Camera pinhole_camera(double fx, double fy, double cx, double cy, const ArrayLike& size) {
  return {pinhole(fx, fy, cx, cy), size_of_argument(size, "size")};
}

Camera parallel_camera(double sx, double sy, double cx, double cy, const ArrayLike& size, double ox,
                       double oy) {
  return {Parallel({sx, sy, cx, cy, ox, oy}), size_of_argument(size, "size")};
}

Camera camera_from_matrix(const ArrayLike& matrix, const ArrayLike& size,
                          const ArrayLike& distortion, bool fisheye) {
  const Eigen::Matrix3d k = matrix3(matrix, "matrix");
  if (k(0, 1) != 0 || k(1, 0) != 0 || k.row(2) != Eigen::RowVector3d(0, 0, 1))
    throw Error("matrix: must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  const auto make = fisheye ? camera_with_distortion<Fisheye> : camera_with_distortion<Perspective>;
  return make(k(0, 0), k(1, 1), k(0, 2), k(1, 2), size, distortion);
}

Camera double_sphere_camera(double fx, double fy, double cx, double cy, const ArrayLike& size,
                            double xi, double alpha) {
  return {DoubleSphere({fx, fy, cx, cy, xi, alpha}), size_of_argument(size, "size")};
}

Camera extended_unified_camera(double fx, double fy, double cx, double cy, const ArrayLike& size,
                               double alpha, double beta) {
  return {ExtendedUnified({fx, fy, cx, cy, alpha, beta}), size_of_argument(size, "size")};
}

}  // namespace

void define_camera_constructors(py::class_<Camera>& camera) {
  camera
      .def(py::init([](const py::args&, const py::kwargs&) -> Camera {
             throw Error(
                 "Camera: is made by Camera.pinhole, perspective, fisheye, double_sphere, "
                 "extended_unified, parallel or from_matrix");
           }),
           "Raises Error: cameras are made by `pinhole` and the others.")
      .def_static("pinhole", &pinhole_camera, py::arg("fx"), py::arg("fy"), py::arg("cx"),
                  py::arg("cy"), py::arg("size"),
                  "A pinhole without distortion. Focal lengths and principal point are pixels; "
                  "`size` is (width, height).")
      .def_static("perspective", &camera_with_distortion<Perspective>, py::arg("fx"), py::arg("fy"),
                  py::arg("cx"), py::arg("cy"), py::arg("size"), py::arg("distortion") = py::none(),
                  "A pinhole with Brown-Conrady distortion, polynomial or rational: k1, k2, p1, "
                  "p2, k3, k4, k5, k6, as many as there are.")
      .def_static("fisheye", &camera_with_distortion<Fisheye>, py::arg("fx"), py::arg("fy"),
                  py::arg("cx"), py::arg("cy"), py::arg("size"), py::arg("distortion") = py::none(),
                  "An equidistant fisheye (Kannala-Brandt): k1, k2, k3, k4.")
      .def_static("double_sphere", &double_sphere_camera, py::arg("fx"), py::arg("fy"),
                  py::arg("cx"), py::arg("cy"), py::arg("size"), py::arg("xi"), py::arg("alpha"),
                  "A double sphere (Usenko et al. 2018), as Basalt and Kalibr have it.")
      .def_static("extended_unified", &extended_unified_camera, py::arg("fx"), py::arg("fy"),
                  py::arg("cx"), py::arg("cy"), py::arg("size"), py::arg("alpha"),
                  py::arg("beta") = 1.0,
                  "An extended unified lens (EUCM); with beta = 1 the unified one (UCM).")
      .def_static("parallel", &parallel_camera, py::arg("sx"), py::arg("sy"), py::arg("cx"),
                  py::arg("cy"), py::arg("size"), py::arg("ox") = 0.0, py::arg("oy") = 0.0,
                  "A parallel projection with scales in pixels per metre; ox and oy make it "
                  "oblique, metres per metre of depth.")
      .def_static("from_matrix", &camera_from_matrix, py::arg("matrix"), py::arg("size"),
                  py::arg("distortion") = py::none(), py::arg("fisheye") = false,
                  "From OpenCV's camera matrix (3, 3) and distortion coefficients.");
}

}  // namespace tagcal::python
