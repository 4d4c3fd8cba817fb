#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "tagcal/detect/types.hpp"

namespace tagcal::python {

// Options from arguments, checked. The camera must outlive them.
DetectOptions detect_options(const std::optional<Camera>& camera, const std::string& refinement,
                             int max_hamming, int threads);

// Parts of bind_detect.
void bind_explain(pybind11::module_& m);
void bind_refine(pybind11::module_& m);

}  // namespace tagcal::python
