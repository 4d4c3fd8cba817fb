#include "python/bindings.hpp"

#include <string>

namespace tagcal::python {
namespace {

namespace py = pybind11;

// pybind11's entry into every function.
PyCFunctionWithKeywords entry = nullptr;

// The TypeError that pybind11 raised, in one line; the error itself if it is another one.
void explain(PyObject* arguments, PyObject* named) {
  py::error_already_set error;
  try {
    const auto text = py::cast<std::string>(py::str(error.value()));
    if (text.find("(): incompatible ") != std::string::npos) {
      const py::handle by_name(named ? named : Py_None);
      const py::object sentence = py::module_::import("tagcal._calls")
                                      .attr("sentence")(text, py::handle(arguments), by_name);
      PyErr_SetObject(PyExc_TypeError, sentence.ptr());
      return;
    }
  } catch (const std::exception&) {
    PyErr_Clear();
  }
  error.restore();
}

PyObject* call(PyObject* self, PyObject* arguments, PyObject* named) {
  PyObject* const result = entry(self, arguments, named);
  if (!result && PyErr_ExceptionMatches(PyExc_TypeError)) explain(arguments, named);
  return result;
}

// Puts `call` before pybind11's entry. Other versions of pybind11 may call functions in another
// way: their errors stay as they are.
void redirect(PyObject* function) {
  if (PyInstanceMethod_Check(function)) function = PyInstanceMethod_GET_FUNCTION(function);
  if (!PyCFunction_CheckExact(function)) return;
  PyMethodDef* const method = reinterpret_cast<PyCFunctionObject*>(function)->m_ml;
  if (method->ml_flags != (METH_VARARGS | METH_KEYWORDS)) return;
  const auto present =
      reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(method->ml_meth));
  if (present == &call) return;
  if (!entry) entry = present;
  if (present == entry)
    method->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&call));
}

}  // namespace

void explain_wrong_calls(const py::module_& m) {
  for (const auto& [name, value] : py::dict(m.attr("__dict__"))) {
    redirect(value.ptr());
    if (!PyType_Check(value.ptr())) continue;
    for (const auto& [member_name, member] : py::dict(value.attr("__dict__"))) {
      if (py::isinstance<py::staticmethod>(member))
        redirect(py::object(member.attr("__func__")).ptr());
      else
        redirect(member.ptr());
    }
  }
}

}  // namespace tagcal::python
