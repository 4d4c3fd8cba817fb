#pragma once

#include <pybind11/pybind11.h>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::python {

// A Pose, or a matrix (4, 4) of a rigid motion. Throws Error with the argument's name.
Pose pose_of(pybind11::handle argument, const char* name);

}  // namespace tagcal::python
