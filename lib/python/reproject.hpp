#pragma once

#include <pybind11/pybind11.h>

namespace tagcal::python {

// A part of bind_reproject: Panorama, PlaneRaster, and the cameras that show what another one sees.
void bind_reproject_targets(pybind11::module_& m);

}  // namespace tagcal::python
