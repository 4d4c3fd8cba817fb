#pragma once

#include <pybind11/pybind11.h>

#include <vector>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::python {

// A Pose, or a matrix (4, 4) of a rigid motion. Throws Error with the argument's name.
Pose pose_of(pybind11::handle argument, const char* name);

// What pose_of takes.
class PoseLike : public pybind11::object {
  static bool is_any(PyObject*) { return true; }

 public:
  PYBIND11_OBJECT_DEFAULT(PoseLike, pybind11::object, is_any)
};

// One pose or many: a Pose, a matrix (4, 4), a list of these, or an array (N, 4, 4).
class PosesLike : public pybind11::object {
  static bool is_any(PyObject*) { return true; }

 public:
  PYBIND11_OBJECT_DEFAULT(PosesLike, pybind11::object, is_any)
};
std::vector<Pose> poses_of(const PosesLike& argument, const char* name);

}  // namespace tagcal::python

namespace pybind11::detail {
template <>
struct handle_type_name<tagcal::python::PoseLike> {
  static constexpr auto name = const_name("PoseLike");
};
template <>
struct handle_type_name<tagcal::python::PosesLike> {
  static constexpr auto name = const_name("PosesLike");
};
}  // namespace pybind11::detail
