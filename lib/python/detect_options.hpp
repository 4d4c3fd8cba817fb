#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <optional>
#include <string>

#include "python/arrays.hpp"
#include "tagcal/detect/types.hpp"

namespace tagcal::python {

// Options from arguments, checked. The camera must outlive them.
DetectOptions detect_options(const std::optional<Camera>& camera, const std::string& refinement,
                             int max_hamming, int threads);

// The four corners of a tag as an array (4, 2); their centre as text.
py::array_t<double> corners_array(const std::array<Eigen::Vector2d, 4>& corners);
std::string centre_text(const std::array<Eigen::Vector2d, 4>& corners);

// Parts of bind_detect.
void bind_detect_tags(pybind11::module_& m);
void bind_explain(pybind11::module_& m);
void bind_refine(pybind11::module_& m);

}  // namespace tagcal::python
