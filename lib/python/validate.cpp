#include <pybind11/pybind11.h>

#include "python/bindings.hpp"

namespace tagcal::python {

void bind_validate(pybind11::module_&) {}

}  // namespace tagcal::python
