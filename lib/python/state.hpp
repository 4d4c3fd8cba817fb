#pragma once

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <ranges>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "python/members.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/error.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/uncertainty/seen_region.hpp"
#include "tagcal/version.hpp"

// What pickle stores of a struct of the library: its members, in their order, by one rule for all
// structs. A struct with a member that the rule does not know does not compile.

namespace tagcal::python {

namespace py = pybind11;

template <>
inline constexpr auto kMembers<Observation> = std::tuple(&Observation::id, &Observation::pixel,
                                                         &Observation::covariance_px2);

namespace state {

template <typename T, template <typename...> class Template>
inline constexpr bool kIs = false;
template <template <typename...> class Template, typename... Parts>
inline constexpr bool kIs<Template<Parts...>, Template> = true;

// Classes of the module that have a state of their own.
template <typename T>
inline constexpr bool kHasItsOwn =
    std::is_same_v<T, Pose> || std::is_same_v<T, Camera> || std::is_same_v<T, Board>;

template <typename T>
concept Dense = std::is_base_of_v<Eigen::DenseBase<T>, T>;
template <typename T>
concept Matrix = Dense<T> && T::ColsAtCompileTime != 1;

[[noreturn]] inline void refuse() { throw py::cast_error("not a state"); }

inline py::tuple parts(py::handle state, std::size_t count) {
  if (!py::isinstance<py::tuple>(state)) refuse();
  auto tuple = py::reinterpret_borrow<py::tuple>(state);
  if (tuple.size() != count) refuse();
  return tuple;
}

template <typename T>
py::object of(const T& value);
template <typename T>
T read(py::handle state);

template <typename Tuple, std::size_t... Is>
py::tuple of_all(const Tuple& values, std::index_sequence<Is...>) {
  return py::make_tuple(of(std::get<Is>(values))...);
}

template <typename Tuple>
py::tuple of_all(const Tuple& values) {
  return of_all(values, std::make_index_sequence<std::tuple_size_v<Tuple>>());
}

template <typename T>
py::object of(const T& value) {
  if constexpr (kHasItsOwn<T> || std::is_arithmetic_v<T> || Dense<T>) {
    return py::cast(value);
  } else if constexpr (std::is_same_v<T, Affine>) {
    return py::cast(Eigen::Matrix4d(value.matrix()));
  } else if constexpr (std::is_same_v<T, Lens>) {
    return py::cast(Camera{value, {}});
  } else if constexpr (std::is_same_v<T, const Model*>) {
    return value ? of(std::string(value->name())) : py::none();
  } else if constexpr (std::is_same_v<T, SeenRegion>) {
    return py::make_tuple(of(value.size()), of(value.hull()));
  } else if constexpr (std::is_enum_v<T>) {
    return py::cast(static_cast<std::underlying_type_t<T>>(value));
  } else if constexpr (std::is_same_v<T, std::string>) {
    return py::bytes(value);  // names of files need not be UTF-8
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return py::bytes(value.string());
  } else if constexpr (std::is_same_v<T, std::monostate>) {
    return py::none();
  } else if constexpr (kIs<T, std::optional>) {
    return value ? py::make_tuple(of(*value)) : py::object(py::none());
  } else if constexpr (kIs<T, std::pair>) {
    return py::make_tuple(of(value.first), of(value.second));
  } else if constexpr (kIs<T, std::variant>) {
    return std::visit([&](const auto& v) { return py::make_tuple(value.index(), of(v)); }, value);
  } else if constexpr (std::ranges::range<T>) {
    py::list list;
    for (const auto& element : value) list.append(of(element));
    return list;
  } else {
    return of_all(tie_members(value));
  }
}

template <typename T, std::size_t... Is>
T read_members(const py::tuple& tuple, std::index_sequence<Is...>) {
  using Members = decltype(tie_members(std::declval<T&>()));
  if constexpr (std::is_default_constructible_v<T>) {
    T value;
    const Members members = tie_members(value);
    ((std::get<Is>(members) = read<std::decay_t<std::tuple_element_t<Is, Members>>>(tuple[Is])),
     ...);
    return value;
  } else {
    return {read<std::decay_t<std::tuple_element_t<Is, Members>>>(tuple[Is])...};
  }
}

template <typename T, std::size_t I = 0>
T read_variant(std::size_t index, py::handle state) {
  if constexpr (I == std::variant_size_v<T>)
    refuse();
  else if (index == I)
    return read<std::variant_alternative_t<I, T>>(state);
  else
    return read_variant<T, I + 1>(index, state);
}

template <typename T>
T read_range(py::handle state) {
  T range{};
  if (!py::isinstance<py::list>(state)) refuse();
  const auto list = py::reinterpret_borrow<py::list>(state);
  if constexpr (requires { range.push_back(range.front()); }) {
    for (const py::handle& element : list)
      range.push_back(read<std::decay_t<decltype(range.front())>>(element));
  } else if constexpr (requires { typename T::mapped_type; }) {
    using Pair = std::pair<typename T::key_type, typename T::mapped_type>;
    for (const py::handle& element : list) range.insert(read<Pair>(element));
  } else {
    if (list.size() != range.size()) refuse();
    for (std::size_t i = 0; i < range.size(); ++i)
      range[i] = read<std::decay_t<decltype(range[i])>>(list[i]);
  }
  return range;
}

template <typename T>
T read(py::handle state) {
  if constexpr (kHasItsOwn<T> || std::is_arithmetic_v<T> || Dense<T>) {
    return py::cast<T>(state);
  } else if constexpr (std::is_same_v<T, Affine>) {
    return Affine(py::cast<Eigen::Matrix4d>(state));
  } else if constexpr (std::is_same_v<T, Lens>) {
    return py::cast<Camera>(state).lens;
  } else if constexpr (std::is_same_v<T, const Model*>) {
    return state.is_none() ? nullptr : &Model::named(py::cast<std::string>(state));
  } else if constexpr (std::is_same_v<T, SeenRegion>) {
    const py::tuple two = parts(state, 2);
    return {read<ImageSize>(two[0]), read<std::vector<Eigen::Vector2d>>(two[1])};
  } else if constexpr (std::is_enum_v<T>) {
    return static_cast<T>(py::cast<std::underlying_type_t<T>>(state));
  } else if constexpr (std::is_same_v<T, std::string>) {
    return py::cast<std::string>(state);
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return py::cast<std::string>(state);
  } else if constexpr (std::is_same_v<T, std::monostate>) {
    return {};
  } else if constexpr (kIs<T, std::optional>) {
    if (state.is_none()) return std::nullopt;
    return read<typename T::value_type>(py::object(parts(state, 1)[0]));
  } else if constexpr (kIs<T, std::pair>) {
    const py::tuple two = parts(state, 2);
    return {read<typename T::first_type>(two[0]), read<typename T::second_type>(two[1])};
  } else if constexpr (kIs<T, std::variant>) {
    const py::tuple two = parts(state, 2);
    return read_variant<T>(py::cast<std::size_t>(two[0]), two[1]);
  } else if constexpr (std::ranges::range<T>) {
    return read_range<T>(state);
  } else {
    constexpr std::size_t kCount = std::tuple_size_v<decltype(tie_members(std::declval<T&>()))>;
    return read_members<T>(parts(state, kCount), std::make_index_sequence<kCount>());
  }
}

}  // namespace state

// Defines what pickle and copy call. The state begins with the version of the library, as the
// members of another version may differ.
template <typename T, typename Class>
void define_pickle(Class& cls) {
  const auto name = py::cast<std::string>(cls.attr("__name__"));
  cls.def(py::pickle(
      [](const T& value) { return py::make_tuple(TAGCAL_VERSION, state::of(value)); },
      [name](const py::tuple& tuple) {
        const std::string what = "pickle: no state of a " + name + " of tagcal " + TAGCAL_VERSION;
        try {
          const py::tuple two = state::parts(tuple, 2);
          if (py::cast<std::string>(two[0]) == TAGCAL_VERSION) return state::read<T>(two[1]);
        } catch (const py::cast_error&) {
          throw Error(what);
        }
        throw Error(what);
      }));
}

}  // namespace tagcal::python
