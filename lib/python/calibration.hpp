#pragma once

#include <pybind11/pybind11.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.hpp"
#include "python/records.hpp"
#include "tagcal/estimate/types.hpp"

// The parts of bind_calibrate and bind_uncertainty, one file each.

namespace tagcal::python {

void bind_regions(py::module_& m);
void bind_uncertain_camera(py::module_& m);
void bind_calibration_parts(py::module_& m);
void bind_calibration(py::module_& m);
void bind_advice(py::module_& m);
void bind_lens_fit(py::module_& m);

// Values by the names of a lens' parameters; empty if there are no values.
NumbersByName by_name(const Lens& lens, const std::vector<double>& values);

// Throws Error unless the value is > 0; infinity too.
void check_distance(double value, const char* name);

// "at 2.5 m", "at infinity".
std::string distance_text(double distance_m);

}  // namespace tagcal::python
