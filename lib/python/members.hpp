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

// For aggregates without bases, of 1 to 32 members.
template <typename T>
auto tie_aggregate(T& t) {
  constexpr std::size_t n = members::count<std::remove_const_t<T>>();
#define TAGCAL_TIE(count, ...)    \
  if constexpr (n == (count)) {   \
    auto& [__VA_ARGS__] = t;      \
    return std::tie(__VA_ARGS__); \
  }
  // clang-format off
  TAGCAL_TIE(1, m0)
  TAGCAL_TIE(2, m0, m1)
  TAGCAL_TIE(3, m0, m1, m2)
  TAGCAL_TIE(4, m0, m1, m2, m3)
  TAGCAL_TIE(5, m0, m1, m2, m3, m4)
  TAGCAL_TIE(6, m0, m1, m2, m3, m4, m5)
  TAGCAL_TIE(7, m0, m1, m2, m3, m4, m5, m6)
  TAGCAL_TIE(8, m0, m1, m2, m3, m4, m5, m6, m7)
  TAGCAL_TIE(9, m0, m1, m2, m3, m4, m5, m6, m7, m8)
  TAGCAL_TIE(10, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9)
  TAGCAL_TIE(11, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10)
  TAGCAL_TIE(12, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11)
  TAGCAL_TIE(13, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12)
  TAGCAL_TIE(14, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13)
  TAGCAL_TIE(15, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14)
  TAGCAL_TIE(16, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15)
  TAGCAL_TIE(17, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16)
  TAGCAL_TIE(18, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17)
  TAGCAL_TIE(19, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18)
  TAGCAL_TIE(20, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19)
  TAGCAL_TIE(21, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20)
  TAGCAL_TIE(22, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21)
  TAGCAL_TIE(23, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22)
  TAGCAL_TIE(24, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23)
  TAGCAL_TIE(25, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24)
  TAGCAL_TIE(26, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25)
  TAGCAL_TIE(27, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25, m26)
  TAGCAL_TIE(28, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25, m26, m27)
  TAGCAL_TIE(29, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25, m26, m27, m28)
  TAGCAL_TIE(30, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25, m26, m27, m28, m29)
  TAGCAL_TIE(31, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25, m26, m27, m28, m29, m30)
  TAGCAL_TIE(32, m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17,
             m18, m19, m20, m21, m22, m23, m24, m25, m26, m27, m28, m29, m30, m31)
  // clang-format on
#undef TAGCAL_TIE
  static_assert(n >= 1 && n <= 32);
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
