#include <pybind11/pybind11.h>

#include "python/bindings.hpp"
#include "tagcal/error.hpp"
#include "tagcal/version.hpp"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  using namespace tagcal::python;
  m.attr("__name__") = "tagcal";  // users know the classes from the package
  m.doc() = "Where a camera is, how it projects, and how far to trust that.";
  m.attr("__version__") = TAGCAL_VERSION;
  const py::object error = py::register_exception<tagcal::Error>(m, "Error", PyExc_ValueError);
  error.attr("__doc__") = "Bad input: one line that names the argument, or the file and the key.";

  bind_geometry(m);
  bind_camera(m);
  bind_solvers(m);
  bind_boards(m);
  bind_dataset(m);
  bind_scene(m);
  bind_detect(m);
  bind_pose(m);
  bind_calibrate(m);
  bind_uncertainty(m);
  bind_reproject(m);
  bind_files(m);
  bind_validate(m);

  py::list names;
  for (const auto& [name, value] : m.attr("__dict__").cast<py::dict>())
    if (py::cast<std::string>(name).front() != '_') names.append(name);
  m.attr("__all__") = names;
  m.attr("__name__") = "tagcal._core";
}
