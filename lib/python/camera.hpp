#pragma once

#include <pybind11/pybind11.h>

#include "tagcal/camera/camera.hpp"

namespace tagcal::python {

// (width, height), both whole numbers > 0. Throws Error with the argument's name.
ImageSize size_of_argument(pybind11::handle argument, const char* name);

void define_camera_constructors(pybind11::class_<Camera>& camera);

}  // namespace tagcal::python
