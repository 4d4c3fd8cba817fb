#include <pybind11/pybind11.h>

#include <exception>
#include <string>

#include "python/bindings.hpp"
#include "python/findings.hpp"
#include "tagcal/error.hpp"
#include "tagcal/version.hpp"

namespace {

namespace py = pybind11;

// tagcal.Error, a ValueError. Names of files need not be UTF-8: what is not is replaced.
void define_error(py::module_& m) {
  static PyObject* const error = PyErr_NewExceptionWithDoc(
      "tagcal.Error", "Bad input: one line that names the argument, or the file and the key.",
      PyExc_ValueError, nullptr);
  if (error == nullptr) throw py::error_already_set();
  m.add_object("Error", py::reinterpret_borrow<py::object>(error));
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const tagcal::Error& e) {
      const std::string text = tagcal::python::in_python(e.what());
      const auto message = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
          text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace"));
      PyErr_SetObject(error, message.ptr());
    }
  });
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  using namespace tagcal::python;
  m.attr("__name__") = "tagcal";  // users know the classes from the package
  m.doc() = "Where a camera is, how it projects, and how far to trust that.";
  m.attr("__version__") = TAGCAL_VERSION;
  define_error(m);

  bind_geometry(m);
  bind_camera(m);
  bind_solvers(m);
  bind_boards(m);
  bind_dataset(m);
  bind_scene(m);
  bind_detect(m);
  bind_pose(m);
  bind_calibrate(m);
  bind_rig(m);
  bind_check(m);
  bind_handeye(m);
  bind_uncertainty(m);
  bind_reproject(m);
  bind_stereo(m);
  bind_files(m);
  bind_validate(m);
  bind_fleet(m);

  py::list names;
  for (const auto& [name, value] : m.attr("__dict__").cast<py::dict>())
    if (py::cast<std::string>(name).front() != '_') names.append(name);
  m.attr("__all__") = names;
  m.attr("__name__") = "tagcal._core";
  // `help(tagcal)` prints the classes of the module "tagcal" in full, thousands of lines; theirs is
  // _core, and the package lists them.
  for (const py::handle& name : names)
    if (const py::object value = m.attr(name);
        PyType_Check(value.ptr()) && !value.is(m.attr("Error")))
      value.attr("__module__") = "tagcal._core";
  m.def("_in_python", py::overload_cast<std::string_view>(&in_python), py::arg("sentence"));
  explain_wrong_calls(m);
}
