#include "python/camera.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/error.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::python {

namespace {

using Pixels = py::array_t<double>;
using Directions = py::array_t<double>;
using Derivatives = py::array_t<double>;

std::string lens_name(const Camera& camera) { return std::string(kind_of(camera.lens).name); }

NumbersByName parameter_values(const Camera& camera) {
  return numbers_by_name(parameter_names(camera.lens), parameters(camera.lens));
}

Eigen::Matrix3d camera_matrix(const Camera& camera) {
  const auto p = parameters(camera.lens);
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = p[0];
  k(1, 1) = p[1];
  k(0, 2) = p[2];
  k(1, 2) = p[3];
  return k;
}

py::array_t<double> distortion(const Camera& camera) {
  const auto p = parameters(camera.lens).subspan(4);
  return py::array_t<double>(static_cast<py::ssize_t>(p.size()), p.data());
}

Pose pose_or_identity(const PoseLike& pose) {
  return pose.is_none() ? Pose() : pose_of(pose, "camera_from_points");
}

// Projects in blocks, so that what is thrown away (`valid`) stays in the cache.
void project_blocks(const Camera& camera, const Pose& pose, std::span<const Eigen::Vector3d> points,
                    double* out) {
  constexpr std::size_t kBlock = 4096;
  std::array<std::uint8_t, kBlock> valid;
  const bool is_aligned = reinterpret_cast<std::uintptr_t>(out) % alignof(Eigen::Vector2d) == 0;
  std::vector<Eigen::Vector2d> copy(is_aligned ? 0 : std::min(kBlock, points.size()));
  for (std::size_t i = 0; i < points.size(); i += kBlock) {
    const std::size_t n = std::min(kBlock, points.size() - i);
    auto* const pixels = is_aligned ? reinterpret_cast<Eigen::Vector2d*>(out + 2 * i) : copy.data();
    project(camera.lens, pose, points.subspan(i, n), {pixels, n}, {valid.data(), n});
    if (!is_aligned) std::copy_n(copy.front().data(), 2 * n, out + 2 * i);
  }
}

Pixels project_points(const Camera& camera, const ArrayLike& points, const PoseLike& pose,
                      const OutputArray& out) {
  const Rows3 rows(points, "points", Rows3::Check::none);
  const Pose camera_from_points = pose_or_identity(pose);
  const std::array<py::ssize_t, 2> shape = {static_cast<py::ssize_t>(rows.size()), 2};
  const std::span<const py::ssize_t> expected =
      rows.is_single() ? std::span(shape).subspan(1) : std::span(shape);
  Pixels result = out.is_none() ? Pixels(std::vector(expected.begin(), expected.end()))
                                : py::reinterpret_borrow<Pixels>(out);
  double* const pixels = output_array(result, "out", expected);
  py::gil_scoped_release release;
  project_blocks(camera, camera_from_points, rows.span(), pixels);
  return result;
}

std::pair<Directions, Directions> rays_of_pixels(const Camera& camera, const ArrayLike& pixels) {
  const Rows2 rows(pixels, "pixels", Rows2::Check::none);
  std::vector<Eigen::Vector3d> origins(rows.size()), directions(rows.size());
  {
    py::gil_scoped_release release;
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::nan(""));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::optional<Ray> ray =
          rows[i].allFinite() ? ray_in_camera(camera.lens, rows[i]) : std::nullopt;
      origins[i] = ray ? ray->origin : none;
      directions[i] = ray ? ray->direction : none;
    }
  }
  Directions o = array_of(std::span<const Eigen::Vector3d>(origins));
  Directions d = array_of(std::span<const Eigen::Vector3d>(directions));
  if (rows.is_single()) return {o.reshape({3}), d.reshape({3})};
  return {o, d};
}

Directions unproject_pixels(const Camera& camera, const ArrayLike& pixels) {
  if (!kind_of(camera.lens).is_central)
    throw Error("unproject: the rays of a parallel lens have no common centre; use rays");
  return rays_of_pixels(camera, pixels).second;
}

std::variant<bool, py::array_t<bool>> pixels_in_image(const Camera& camera,
                                                      const ArrayLike& pixels) {
  const Rows2 rows(pixels, "pixels", Rows2::Check::none);
  if (rows.is_single()) return contains(camera.image_size, rows[0]);
  py::array_t<bool> inside(static_cast<py::ssize_t>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    inside.mutable_data()[i] = contains(camera.image_size, rows[i]);
  return inside;
}

// The free parameters of a model, or all of the lens.
std::vector<FreeParameter> free_parameters(const Camera& camera,
                                           const std::optional<std::string>& model) {
  if (model) {
    const Model& named = Model::named(*model);
    if (&named.kind() != &kind_of(camera.lens))
      throw Error("model: \"" + *model + "\" is no model of a " + lens_name(camera) + " lens");
    return named.free();
  }
  std::vector<FreeParameter> all;
  int index = 0;
  for (const std::string_view name : parameter_names(camera.lens)) all.push_back({name, {index++}});
  return all;
}

std::tuple<Pixels, Derivatives, Derivatives> jacobians(const Camera& camera,
                                                       const ArrayLike& points,
                                                       const PoseLike& pose,
                                                       const std::optional<std::string>& model) {
  const Rows3 rows(points, "points", Rows3::Check::none);
  const Pose camera_from_points = pose_or_identity(pose);
  const std::vector<FreeParameter> free = free_parameters(camera, model);
  const auto n = static_cast<py::ssize_t>(rows.size());
  const auto k = static_cast<py::ssize_t>(free.size());
  py::array_t<double> by_pose({n, py::ssize_t{2}, py::ssize_t{6}});
  py::array_t<double> by_parameters({n, py::ssize_t{2}, k});
  std::vector<Eigen::Vector2d> pixels(rows.size());
  std::vector<std::uint8_t> valid(rows.size());
  const ProjectionOutput output = {
      pixels,
      valid,
      {by_pose.mutable_data(), static_cast<std::size_t>(by_pose.size())},
      {by_parameters.mutable_data(), static_cast<std::size_t>(by_parameters.size())}};
  {
    py::gil_scoped_release release;
    project_with_jacobians(camera.lens, camera_from_points, rows.span(), free, output);
  }
  return {array_of(std::span<const Eigen::Vector2d>(pixels)), by_pose, by_parameters};
}

std::string representation(const Camera& camera) {
  std::string text = "<Camera " + lens_name(camera) + " " + size_text(camera.image_size);
  const auto names = parameter_names(camera.lens);
  const auto values = parameters(camera.lens);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (i < 4 || values[i] != 0) text += " " + std::string(names[i]) + "=" + number(values[i], 7);
  return text + ">";
}

void define_properties(py::class_<Camera>& camera) {
  camera
      .def_property_readonly(
          "size",
          [](const Camera& c) { return std::pair(c.image_size.width, c.image_size.height); },
          "(width, height), pixels.")
      .def_property_readonly(
          "lens", &lens_name,
          "\"perspective\", \"fisheye\", \"parallel\", \"double sphere\" or \"extended "
          "unified\".")
      .def_property_readonly("parameters", &parameter_values,
                             "The lens parameters by name: fx, fy, cx, cy, k1, ..")
      .def_property_readonly("matrix", &camera_matrix, "OpenCV's camera matrix (3, 3).")
      .def_property_readonly("distortion", &distortion,
                             "The coefficients after fx, fy, cx, cy, in OpenCV's order.")
      .def("__repr__", &representation);
}

void define_state(py::class_<Camera>& camera) {
  camera
      .def(
          "to_dict",
          [](const Camera& c) {
            py::dict dict;
            dict["lens"] = lens_name(c);
            dict["size"] = std::vector<int>{c.image_size.width, c.image_size.height};
            dict["parameters"] = parameter_values(c);
            return dict;
          },
          "Lens, size and parameters as plain values.")
      .def(
          "__eq__",
          [](const Camera& a, const py::object& other) {
            if (!py::isinstance<Camera>(other)) return false;
            const Camera& b = py::cast<const Camera&>(other);
            return a.image_size == b.image_size && a.lens.index() == b.lens.index() &&
                   std::ranges::equal(parameters(a.lens), parameters(b.lens));
          },
          py::arg("other"))
      .def(py::pickle(
          [](const Camera& c) {
            const auto p = parameters(c.lens);
            return py::make_tuple(c.lens.index(), std::vector<double>(p.begin(), p.end()),
                                  c.image_size.width, c.image_size.height);
          },
          [](const py::tuple& state) {
            if (state.size() != 4) throw Error("not the state of a camera");
            const auto values = py::cast<std::vector<double>>(state[1]);
            const ImageSize size = {py::cast<int>(state[2]), py::cast<int>(state[3])};
            const auto index = py::cast<std::size_t>(state[0]);
            if (index >= lens_kinds().size() ||
                values.size() != lens_kinds()[index].parameters.size())
              throw Error("not the state of a camera");
            return Camera{make_lens(lens_kinds()[index], values), size};
          }));
}

void define_projection(py::class_<Camera>& camera) {
  camera
      .def("project", &project_points, py::arg("points"),
           py::arg("camera_from_points") = py::none(), py::arg("out") = py::none(),
           "The pixels (N, 2) of points (N, 3), metres, in the camera frame, or in the frame of "
           "the Pose `camera_from_points`. NaN where the lens has no pixel: behind the camera, "
           "beyond the fold of the distortion. One point (3,) gives (2,). `out`: a float64 array "
           "that takes the result.")
      .def("unproject", &unproject_pixels, py::arg("pixels"),
           "The unit directions (N, 3) of the rays of pixels (N, 2), in the camera frame. NaN "
           "where no point projects there.")
      .def("rays", &rays_of_pixels, py::arg("pixels"),
           "The rays of pixels (N, 2): origins (N, 3), which differ for a parallel lens, and unit "
           "directions (N, 3).")
      .def("jacobians", &jacobians, py::arg("points"), py::arg("camera_from_points") = py::none(),
           py::arg("model") = py::none(),
           "Pixels (N, 2), their derivatives by a step (omega rad, tau m) of the pose, R <- "
           "exp(omega) R, t <- t + tau, (N, 2, 6), and by the free parameters of a model (by "
           "default: all of the lens) (N, 2, K).")
      .def("contains", &pixels_in_image, py::arg("pixels"),
           "True for each of the pixels (N, 2) that lies in the image, an array (N,); one pixel "
           "(2,) "
           "gives a bool. `unproject` takes pixels outside of the image, too.")
      .def(
          "field_of_view_rad",
          [](const Camera& c) {
            std::optional<std::tuple<double, double, double>> angles;
            if (const std::optional<FieldOfView> view = field_of_view(c))
              angles = {view->horizontal_rad, view->vertical_rad, view->diagonal_rad};
            return angles;
          },
          "Horizontal, vertical and diagonal field of view; None if the border has no rays.")
      .def(
          "resized",
          [](const Camera& c, const ArrayLike& size) {
            return resized(c, size_of_argument(size, "size"));
          },
          py::arg("size"), "The camera of a picture resized to (width, height).");
}

}  // namespace

void bind_camera(py::module_& m) {
  py::class_<Camera> camera(m, "Camera",
                            "A lens and the size of the image behind it. The camera looks along "
                            "z, x is right, y is down.");
  define_camera_constructors(camera);
  define_properties(camera);
  define_state(camera);
  define_projection(camera);
  m.def(
      "model_names",
      [] {
        std::vector<std::string> names;
        for (const Model& model : Model::all()) names.emplace_back(model.name());
        return names;
      },
      "The models of the ladder, from the smallest to the largest number of parameters.");
}

}  // namespace tagcal::python
