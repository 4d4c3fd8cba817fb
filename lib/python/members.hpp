#pragma once

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

// The members of an aggregate in their order, without a list of them.

namespace tagcal::python {

namespace members {

struct Anything {
  template <typename T>
  operator T() const;  // never defined: for `requires` alone
};

template <typename T, std::size_t... Is>
consteval bool takes(std::index_sequence<Is...>) {
  return requires { T{(static_cast<void>(Is), Anything())...}; };
}

// The largest number of values in braces that make a T.
template <typename T, std::size_t N = 40>
consteval std::size_t count() {
  if constexpr (takes<T>(std::make_index_sequence<N>()))
    return N;
  else
    return count<T, N - 1>();
}

}  // namespace members

// For aggregates without bases, of 1 to 32 members. C++20 names each member of a binding, so that
// there is a line for each number of them.
template <typename T>
auto tie_aggregate(T& t) {
  constexpr std::size_t n = members::count<std::remove_const_t<T>>();
  static_assert(n >= 1 && n <= 32);
  // clang-format off
#define TAGCAL_A_TO_H a, b, c, d, e, f, g, h
#define TAGCAL_I_TO_P i, j, k, l, m, n_, o, p
#define TAGCAL_Q_TO_X q, r, s, t_, u, v, w, x
#define TAGCAL_TIE(count, ...) \
  if constexpr (n == count) { auto& [__VA_ARGS__] = t; return std::tie(__VA_ARGS__); }
  TAGCAL_TIE(1, a)
  TAGCAL_TIE(2, a, b)
  TAGCAL_TIE(3, a, b, c)
  TAGCAL_TIE(4, a, b, c, d)
  TAGCAL_TIE(5, a, b, c, d, e)
  TAGCAL_TIE(6, a, b, c, d, e, f)
  TAGCAL_TIE(7, a, b, c, d, e, f, g)
  TAGCAL_TIE(8, TAGCAL_A_TO_H)
  TAGCAL_TIE(9, TAGCAL_A_TO_H, i)
  TAGCAL_TIE(10, TAGCAL_A_TO_H, i, j)
  TAGCAL_TIE(11, TAGCAL_A_TO_H, i, j, k)
  TAGCAL_TIE(12, TAGCAL_A_TO_H, i, j, k, l)
  TAGCAL_TIE(13, TAGCAL_A_TO_H, i, j, k, l, m)
  TAGCAL_TIE(14, TAGCAL_A_TO_H, i, j, k, l, m, n_)
  TAGCAL_TIE(15, TAGCAL_A_TO_H, i, j, k, l, m, n_, o)
  TAGCAL_TIE(16, TAGCAL_A_TO_H, TAGCAL_I_TO_P)
  TAGCAL_TIE(17, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q)
  TAGCAL_TIE(18, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q, r)
  TAGCAL_TIE(19, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q, r, s)
  TAGCAL_TIE(20, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q, r, s, t_)
  TAGCAL_TIE(21, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q, r, s, t_, u)
  TAGCAL_TIE(22, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q, r, s, t_, u, v)
  TAGCAL_TIE(23, TAGCAL_A_TO_H, TAGCAL_I_TO_P, q, r, s, t_, u, v, w)
  TAGCAL_TIE(24, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X)
  TAGCAL_TIE(25, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y)
  TAGCAL_TIE(26, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z)
  TAGCAL_TIE(27, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z, A)
  TAGCAL_TIE(28, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z, A, B)
  TAGCAL_TIE(29, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z, A, B, C)
  TAGCAL_TIE(30, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z, A, B, C, D)
  TAGCAL_TIE(31, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z, A, B, C, D, E)
  TAGCAL_TIE(32, TAGCAL_A_TO_H, TAGCAL_I_TO_P, TAGCAL_Q_TO_X, y, z, A, B, C, D, E, F)
#undef TAGCAL_TIE
#undef TAGCAL_Q_TO_X
#undef TAGCAL_I_TO_P
#undef TAGCAL_A_TO_H
  // clang-format on
}

// A tuple of pointers to the members of a class with a base, or with an optional matrix, which
// Eigen would make of Anything.
template <typename T>
inline constexpr auto kMembers = nullptr;

// References to all members of an aggregate without bases, of 1 to 32 members, or of a class with
// kMembers.
template <typename T>
auto tie_members(T& t) {
  constexpr auto pointers = kMembers<std::remove_const_t<T>>;
  if constexpr (!std::is_null_pointer_v<std::remove_const_t<decltype(pointers)>>)
    return std::apply([&t](auto... member) { return std::tie(t.*member...); }, pointers);
  else
    return tie_aggregate(t);
}

}  // namespace tagcal::python
