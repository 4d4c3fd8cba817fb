#pragma once

#include <pybind11/pybind11.h>

namespace tagcal::python {

// Makes the TypeError of a call whose arguments fit no signature one line that names the argument
// (tagcal/_calls.py), for all functions, constructors and methods of the module.
void explain_wrong_calls(const pybind11::module_& m);

}  // namespace tagcal::python
