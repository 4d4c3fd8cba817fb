#include <pybind11/eigen.h>
#include <pybind11/operators.h>
#include <pybind11/pybind11.h>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal::python {

Pose pose_of(py::handle argument, const char* name) {
  if (py::isinstance<Pose>(argument)) {
    const Pose& pose = py::cast<const Pose&>(argument);
    if (!pose.matrix().allFinite()) throw Error(std::string(name) + ": must be finite");
    return pose;
  }
  const Eigen::Matrix4d matrix = matrix4(argument, name);
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw Error(std::string(name) + ": the last row of a pose must be 0, 0, 0, 1");
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  return {rotation_from_matrix(rotation, name), matrix.topRightCorner<3, 1>()};
}

std::vector<Pose> poses_of(const PosesLike& argument, const char* name) {
  const bool is_array = py::isinstance<py::array>(argument);
  const bool is_list = py::isinstance<py::list>(argument) || py::isinstance<py::tuple>(argument);
  if (!is_list && !(is_array && py::reinterpret_borrow<py::array>(argument).ndim() == 3)) {
    if (is_array || py::isinstance<Pose>(argument)) return {pose_of(argument, name)};
    throw Error(std::string(name) +
                ": must be a Pose, a list of these or an array (N, 4, 4), got " +
                type_name(argument));
  }
  std::vector<Pose> poses;
  for (const py::handle& element : argument) {
    const std::string place = std::string(name) + "[" + std::to_string(poses.size()) + "]";
    poses.push_back(pose_of(element, place.c_str()));
  }
  return poses;
}

namespace {

Pose pose_from_parts(const ArrayLike& rotation, const ArrayLike& translation) {
  const py::array_t<double> array = real_array(rotation, "rotation");
  const Eigen::Vector3d t = vector3(translation, "translation");
  if (array.ndim() == 2 && array.size() == 9)
    return {rotation_from_matrix(matrix3(array, "rotation"), "rotation"), t};
  if (array.size() == 3) {
    const Eigen::Vector3d v = vector3(array, "rotation");
    return {exp_rotation(v), t};
  }
  Eigen::Vector4d q;
  read_matrix(array, "rotation", {q.data(), 4}, 4, 0);
  if (!(q.norm() > 0)) throw Error("rotation: must not be the quaternion 0");
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), t};
}

Eigen::Vector4d quaternion(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  return {q.w(), q.x(), q.y(), q.z()};
}

py::array_t<double> transformed(const Pose& pose, const ArrayLike& points) {
  const Rows3 rows(points, "points", Rows3::Check::none);
  std::vector<Eigen::Vector3d> result(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) result[i] = pose * rows[i];
  py::array_t<double> array = array_of(std::span<const Eigen::Vector3d>(result));
  if (rows.is_single()) return array.reshape({3});
  return array;
}

std::string representation(const Pose& pose) {
  const Eigen::Vector4d q = quaternion(pose);
  const Eigen::Vector3d& t = pose.translation();
  return "Pose([" + number(q[0]) + ", " + number(q[1]) + ", " + number(q[2]) + ", " + number(q[3]) +
         "], [" + number(t[0]) + ", " + number(t[1]) + ", " + number(t[2]) + "])";
}

Pose looking_at(const ArrayLike& eye, const ArrayLike& target, const ArrayLike& up) {
  return camera_from_world_looking_at(vector3(eye, "eye"), vector3(target, "target"),
                                      vector3(up, "up"));
}

Pose on_orbit(const ArrayLike& target, double distance_m, double azimuth_rad, double elevation_rad,
              double twist_rad) {
  return camera_from_world_on_orbit(
      {vector3(target, "target"), distance_m, azimuth_rad, elevation_rad, twist_rad});
}

void define_pose_constructors(py::class_<Pose>& pose) {
  pose.def(py::init<>(), "The identity.")
      .def(py::init([](const PoseLike& matrix) { return pose_of(matrix, "matrix"); }),
           py::arg("matrix"), "From a matrix (4, 4), as `from_matrix`, or a Pose.")
      .def(py::init(&pose_from_parts), py::arg("rotation"), py::arg("translation"),
           "From a rotation, given as a matrix (3, 3), a quaternion (4,) in the order w, x, y, z, "
           "or a rotation vector (3,) in radians, and the origin of the source frame in the "
           "target frame (3,): rvec and tvec of OpenCV, rows or columns.")
      .def_static(
          "from_matrix", [](const ArrayLike& matrix) { return pose_of(matrix, "matrix"); },
          py::arg("matrix"), "From a matrix (4, 4) for homogeneous column vectors.")
      .def_static("looking_at", &looking_at, py::arg("eye"), py::arg("target"), py::arg("up"),
                  "camera_from_world of a camera at `eye` that looks at `target`, image upright "
                  "with respect to `up`, all (3,) in world coordinates.")
      .def_static("on_orbit", &on_orbit, py::arg("target"), py::arg("distance_m"),
                  py::arg("azimuth_rad"), py::arg("elevation_rad"), py::arg("twist_rad") = 0.0,
                  "camera_from_world of a camera on a sphere about `target` (3,) that looks at "
                  "its centre: azimuth about the world's z from +x towards +y, elevation from the "
                  "ground towards +z.");
}

void define_pose_parts(py::class_<Pose>& pose) {
  pose.def_property_readonly(
          "matrix", [](const Pose& pose) { return pose.matrix(); },
          "The matrix (4, 4) for homogeneous column vectors.")
      .def_property_readonly(
          "rotation_matrix", [](const Pose& pose) { return pose.rotation_matrix(); }, "R, (3, 3).")
      .def_property_readonly("quaternion", &quaternion, "(4,), unit, in the order w, x, y, z.")
      .def_property_readonly(
          "rotation_vector", [](const Pose& pose) { return log_rotation(pose.rotation()); },
          "(3,), radians: OpenCV's rvec.")
      .def_property_readonly(
          "translation", [](const Pose& pose) -> Eigen::Vector3d { return pose.translation(); },
          "(3,), metres: the origin of the source frame in the target frame; OpenCV's tvec.");
}

void define_pose_operations(py::class_<Pose>& pose) {
  pose.def(
          "inverse", [](const Pose& pose) { return pose.inverse(); }, "source_from_target.")
      .def(
          "__matmul__",
          [](const Pose& a_from_b, const Pose& b_from_c) { return a_from_b * b_from_c; },
          py::arg("b_from_c"), "a_from_b @ b_from_c = a_from_c.")
      .def("transform", &transformed, py::arg("points"),
           "Points (N, 3) or (3,) of the source frame in the target frame.")
      .def(
          "angle_to",
          [](const Pose& a, const PoseLike& b) {
            return angle_between_rad(a, pose_of(b, "other"));
          },
          py::arg("other"), "The angle of the rotation between two poses, radians, in [0, pi].")
      .def(
          "distance_to",
          [](const Pose& a, const PoseLike& b) {
            return distance_between_m(a, pose_of(b, "other"));
          },
          py::arg("other"), "The distance between the translations of two poses, metres.");
}

void define_pose_state(py::class_<Pose>& pose) {
  pose.def(
          "to_dict",
          [](const Pose& pose) {
            py::dict dict;
            const Eigen::Vector4d q = quaternion(pose);
            const Eigen::Vector3d& t = pose.translation();
            dict["quaternion"] = std::vector<double>(q.data(), q.data() + 4);
            dict["translation"] = std::vector<double>(t.data(), t.data() + 3);
            return dict;
          },
          "Quaternion (w, x, y, z) and translation as lists.")
      .def(
          "__eq__",
          [](const Pose& a, const py::object& other) {
            if (!py::isinstance<Pose>(other)) return false;
            const Pose& b = py::cast<const Pose&>(other);
            return quaternion(a) == quaternion(b) && a.translation() == b.translation();
          },
          py::arg("other"))
      .def("__repr__", &representation)
      .def(py::pickle(
          [](const Pose& pose) {
            return py::make_tuple(quaternion(pose), Eigen::Vector3d(pose.translation()));
          },
          [](const py::tuple& parts) {
            if (parts.size() != 2) throw Error("not the state of a pose");
            return pose_from_parts(py::cast<ArrayLike>(parts[0]), py::cast<ArrayLike>(parts[1]));
          }));
}

}  // namespace

void bind_geometry(py::module_& m) {
  py::class_<Pose> pose(
      m, "Pose",
      "A rigid motion, named target_from_source: x_in_target = R x_in_source + t. "
      "Poses compose by `@`: camera_from_board = camera_from_world @ "
      "world_from_board. Lengths are metres.");
  define_pose_constructors(pose);
  define_pose_parts(pose);
  define_pose_operations(pose);
  define_pose_state(pose);
}

}  // namespace tagcal::python
