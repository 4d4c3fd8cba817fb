#pragma once

#include <pybind11/pybind11.h>

// The parts of the module, one file each. A part comes after those whose classes its signatures
// name.

namespace tagcal::python {

void bind_geometry(pybind11::module_& m);
void bind_camera(pybind11::module_& m);
void bind_solvers(pybind11::module_& m);
void bind_boards(pybind11::module_& m);
void bind_dataset(pybind11::module_& m);
void bind_scene(pybind11::module_& m);
void bind_detect(pybind11::module_& m);
void bind_pose(pybind11::module_& m);
void bind_calibrate(pybind11::module_& m);
void bind_rig(pybind11::module_& m);
void bind_check(pybind11::module_& m);  // after rig
void bind_handeye(pybind11::module_& m);
void bind_stereo(pybind11::module_& m);  // after rig and reproject
void bind_uncertainty(pybind11::module_& m);
void bind_reproject(pybind11::module_& m);
void bind_files(pybind11::module_& m);
void bind_validate(pybind11::module_& m);
void bind_fleet(pybind11::module_& m);  // after calibrate

// Makes the TypeError of a call whose arguments fit no signature one line that names the argument
// (tagcal/_calls.py), for all functions, constructors and methods of the module.
void explain_wrong_calls(const pybind11::module_& m);

}  // namespace tagcal::python
