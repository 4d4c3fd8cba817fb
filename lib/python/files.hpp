#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tagcal::python {

// The rule for remarks of the library: a function that returns a record, or writes a file, returns
// them; a function that returns the thing itself (a camera, a board, a scene) passes them to
// Python's warnings.warn, by this. Needs the GIL.
void warn(const std::vector<std::string>& remarks);

// Refuses an empty path by the argument's name.
void check_path(const std::filesystem::path& file, const char* name);

// The parts of bind_files.
void bind_camera_files(pybind11::module_& m);
void bind_dataset_files(pybind11::module_& m);
void bind_picture_files(pybind11::module_& m);

}  // namespace tagcal::python
