#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "python/arrays.hpp"
#include "python/state.hpp"

// Classes of results: read-only fields, `to_dict()`, pickle, and a representation that reads well.

namespace tagcal::python {

namespace py = pybind11;

// The fields of a Record as plain values: numbers, texts, None, lists and dictionaries; arrays
// become nested lists, other records dictionaries.
py::dict dict_of_fields(const py::object& record);

// Classes that pickle does not store, as they hold functions or rows of a table.
template <typename T>
inline constexpr bool kHasNoState = false;

template <typename Enum>
std::string name_of(Enum value) {
  if constexpr (requires { severity_name(value); })
    return std::string(severity_name(value));
  else if constexpr (requires { verdict_name(value); })
    return std::string(verdict_name(value));
  else if constexpr (requires { kind_name(value); })
    return std::string(kind_name(value));
  else if constexpr (requires { mount_name(value); })
    return mount_name(value);
  else
    return std::string(status_name(value));
}

// A class with read-only fields, named in `_fields` as those of a namedtuple are.
template <typename T, typename... Options>
class Record : public py::class_<T, Options...> {
 public:
  Record(py::handle scope, const char* name, const char* doc)
      : py::class_<T, Options...>(scope, name, doc) {
    this->attr("_fields") = py::tuple();
    const auto to_dict = [](const T& record) {
      return dict_of_fields(py::cast(&record, py::return_value_policy::reference));
    };
    this->def("to_dict", to_dict,
              "The fields as plain values: arrays as nested lists, records as dictionaries.");
    if constexpr (!kHasNoState<T>) define_pickle<T>(*this);
  }

  // `get`: a member, or a function of a const T&. Of members that are enums Python has the name, of
  // matrices a copy, of an ImageSize (width, height). `doc`: what it is, its shape and its unit.
  template <typename Get>
  Record& field(const char* name, Get&& get, const char* doc) {
    if constexpr (std::is_member_object_pointer_v<std::decay_t<Get>>) {
      using Member = std::decay_t<decltype(std::declval<const T&>().*get)>;
      if constexpr (std::is_enum_v<Member>)
        this->def_property_readonly(
            name, [get](const T& record) { return name_of(record.*get); }, doc);
      else if constexpr (state::Matrix<Member>)
        this->def_property_readonly(
            name, [get](const T& record) { return matrix_array(record.*get); }, doc);
      else if constexpr (std::is_same_v<Member, ImageSize>)
        this->def_property_readonly(
            name,
            [get](const T& record) {
              const ImageSize& size = record.*get;
              return std::pair(size.width, size.height);
            },
            doc);
      else
        this->def_readonly(name, get, doc);
    } else if constexpr (std::is_member_function_pointer_v<std::decay_t<Get>>) {
      // A pointer to a member is called with null if someone calls the getter with None.
      this->def_property_readonly(
          name, [get](const T& record) { return (record.*get)(); }, doc);
    } else {
      this->def_property_readonly(name, std::forward<Get>(get), doc);
    }
    const py::tuple fields = this->attr("_fields");
    this->attr("_fields") = fields + py::make_tuple(name);
    return *this;
  }

  // `text`: a function of a const T&; "<Name text>".
  template <typename Text>
  Record& representation(Text&& text) {
    const auto name = py::cast<std::string>(this->attr("__name__"));
    this->def("__repr__",
              [name, text](const T& record) { return "<" + name + " " + text(record) + ">"; });
    return *this;
  }
};

// Makes a class a sequence of the elements of a member. `what`: the name of one of them, "picture".
template <typename T, typename Element>
void define_sequence(py::class_<T>& cls, std::vector<Element> T::*elements, const char* what) {
  cls.def("__len__", [elements](const T& all) { return (all.*elements).size(); })
      .def(
          "__getitem__",
          [elements, what](const T& all, py::ssize_t i) {
            const auto n = std::ssize(all.*elements);
            if (i < 0) i += n;
            if (i < 0 || i >= n) throw py::index_error(std::string("no such ") + what);
            return (all.*elements)[static_cast<std::size_t>(i)];
          },
          py::arg("index"));
}

// Numbers by name, in their order.
class NumbersByName : public py::dict {
 public:
  using py::dict::dict;
};
template <typename Names>
NumbersByName numbers_by_name(const Names& names, const auto& values) {
  NumbersByName numbers;
  std::size_t i = 0;
  for (const double value : values) {
    const auto& name = names[i++];
    numbers[py::str(name.data(), name.size())] = value;
  }
  return numbers;
}

// "1 view", "2 views"; ", 2 views", or nothing of none.
std::string counted(std::size_t count, const std::string& what);
std::string and_counted(std::size_t count, const std::string& what);

// "640 x 480"
std::string size_text(const ImageSize& size);

// A number as a person writes it, with `digits` significant digits.
std::string number(double value, int digits = 6);

}  // namespace tagcal::python

namespace pybind11::detail {
template <>
struct handle_type_name<tagcal::python::NumbersByName> {
  static constexpr auto name = const_name("Dict[str, float]");
};
}  // namespace pybind11::detail
