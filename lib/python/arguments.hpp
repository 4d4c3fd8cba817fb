#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstddef>
#include <string>

// Arguments that may be objects of several kinds. The function that takes one checks it, and its
// error names the argument.

namespace tagcal::python {

template <std::size_t N>
struct ArgumentName {
  consteval ArgumentName(const char (&name)[N]) { std::copy_n(name, N, text); }
  char text[N];
};

// Any object. The name is its type in signatures, which make_stubs.py turns into types of Python.
template <ArgumentName Name>
class Argument : public pybind11::object {
  static bool is_any(PyObject*) { return true; }

 public:
  PYBIND11_OBJECT_DEFAULT(Argument, pybind11::object, is_any)
};

// Throw Error for numbers out of their range: "exposure: must be > 0, got -1". `zero`: what 0
// stands for.
double positive(double value, const char* name);
double not_negative(double value, const char* name, const char* zero = nullptr);
void check_positive(int value, const char* name);
void check_threads(int threads);

// The name of an object's type, for messages.
inline std::string type_name(pybind11::handle object) {
  return pybind11::cast<std::string>(pybind11::type::handle_of(object).attr("__name__"));
}

}  // namespace tagcal::python

namespace pybind11::detail {
template <tagcal::python::ArgumentName Name>
struct handle_type_name<tagcal::python::Argument<Name>> {
  static constexpr auto name = const_name(Name.text);
};
}  // namespace pybind11::detail
