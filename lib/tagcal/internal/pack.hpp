#pragma once

#ifdef __AVX2__
#include <immintrin.h>
#endif

// Packs of numbers: the compiler's vector types, in one register or in several. A formula that is a
// template over the type of its numbers holds for a pack as for a plain number, which is a pack of
// one: it uses + - * / < & ?: and the functions below. Products that are added are fused where the
// processor can.
//
// Files of kernels are compiled for one kind of processor. So there is no standard library here,
// and the namespace is unnamed although this is a header: each file has its own copy. (Of an inline
// function the linker could keep the copy that was compiled for AVX2, and the program would not run
// without AVX2.)
namespace tagcal::internal {
namespace {

#ifdef __AVX2__
constexpr int kRegisterBytes = 32;
#else
constexpr int kRegisterBytes = 16;
#endif
constexpr int kFloatLanes = kRegisterBytes / 4;

typedef double Doubles __attribute__((vector_size(kRegisterBytes)));
typedef decltype(Doubles{} < Doubles{}) Longs;
typedef float Floats __attribute__((vector_size(kRegisterBytes)));
typedef int Ints __attribute__((vector_size(kRegisterBytes)));
typedef unsigned Bits __attribute__((vector_size(kRegisterBytes)));

template <typename Pack>
constexpr int kLanes = sizeof(Pack) / sizeof(double);

// Result of a comparison of packs: bool, or all bits of each lane.
template <typename Pack>
using Mask = decltype(Pack{} < Pack{});

// The number in every lane. (Adding to zero would turn -0 into 0.)
template <typename Pack, typename Number>
inline Pack splat(Number value) {
  return value - Pack{};
}

template <typename P, typename T>
inline P load(const T* from) {
  P result;
  __builtin_memcpy(&result, from, sizeof result);
  return result;
}

template <typename P, typename T>
inline void store(T* to, const P& pack) {
  __builtin_memcpy(to, &pack, sizeof pack);
}

template <typename Pack>
inline Pack larger(Pack a, Pack b) {
  return a > b ? a : b;
}

inline double magnitude(double a) { return __builtin_fabs(a); }
inline Floats magnitude(Floats a) {
  return __builtin_bit_cast(Floats, __builtin_bit_cast(Ints, a) & 0x7fffffff);
}

inline double square_root(double a) { return __builtin_sqrt(a); }
inline Floats square_root(Floats a) {
#ifdef __AVX2__
  return _mm256_sqrt_ps(a);
#else
  Floats result;
  for (int i = 0; i < kFloatLanes; ++i) result[i] = __builtin_sqrtf(a[i]);
  return result;
#endif
}

inline bool all_set(bool mask) { return mask; }

#ifdef __AVX2__
inline Doubles magnitude(Doubles a) {
  return __builtin_bit_cast(Doubles, __builtin_bit_cast(Longs, a) & 0x7fffffffffffffff);
}
inline Doubles square_root(Doubles a) { return _mm256_sqrt_pd(a); }
inline bool all_set(Longs mask) {
  return _mm256_movemask_pd(__builtin_bit_cast(Doubles, mask)) == 15;
}
#endif

}  // namespace
}  // namespace tagcal::internal
