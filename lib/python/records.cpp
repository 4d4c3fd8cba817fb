#include "python/records.hpp"
#include "tagcal/internal/text.hpp"

#include <pybind11/numpy.h>

namespace tagcal::python {
namespace {

py::object plain(const py::handle& value) {
  if (py::hasattr(value, "to_dict")) return value.attr("to_dict")();
  if (py::isinstance<py::array>(value)) return value.attr("tolist")();
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    py::list list;
    for (const py::handle& element : value) list.append(plain(element));
    return list;
  }
  if (py::isinstance<py::dict>(value)) {
    py::dict dict;
    for (const auto& [key, element] : py::reinterpret_borrow<py::dict>(value))
      dict[key] = plain(element);
    return dict;
  }
  return py::reinterpret_borrow<py::object>(value);
}

}  // namespace

py::dict dict_of_fields(const py::object& record) {
  py::dict dict;
  for (const py::handle& name : record.attr("_fields")) dict[name] = plain(record.attr(name));
  return dict;
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string and_counted(std::size_t count, const std::string& what) {
  return count == 0 ? "" : ", " + counted(count, what);
}

std::string size_text(const ImageSize& size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

std::string number(double value, int digits) { return internal::with_digits(value, digits); }

}  // namespace tagcal::python
