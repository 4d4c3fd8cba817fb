#pragma once

#include <pybind11/pybind11.h>

#include <vector>

#include "python/arguments.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal::python {

// A Pose, or a matrix (4, 4) of a rigid motion. Throws Error with the argument's name.
Pose pose_of(pybind11::handle argument, const char* name);

// An argument of pose_of.
using PoseLike = Argument<"PoseLike">;

// One pose or many: a Pose, a matrix (4, 4), a list of these, or an array (N, 4, 4).
using PosesLike = Argument<"PosesLike">;
std::vector<Pose> poses_of(const PosesLike& argument, const char* name);

}  // namespace tagcal::python
