// Compiled with -mavx512f -mavx512dq on x86-64 (lib/CMakeLists.txt); see project_kernels.hpp for
// what must not be included here. Sums over many points only: a tag has but four.
#include "tagcal/camera/kernels/project_kernels.hpp"

#if defined(__AVX512F__) && defined(__AVX512DQ__)

#include <immintrin.h>

#include "tagcal/camera/kernels/parameter_sum_loop.hpp"

namespace tagcal::internal {
namespace {

struct EightMask {
  EightMask operator&(EightMask b) const { return {static_cast<__mmask8>(m & b.m)}; }

  __mmask8 m;
};

// Eight doubles in a register.
struct EightPack {
  static constexpr int kSize = 8;
  using Mask = EightMask;

  EightPack() = default;
  explicit EightPack(double value) : v(_mm512_set1_pd(value)) {}
  explicit EightPack(__m512d values) : v(values) {}

  EightPack operator-() const { return EightPack(_mm512_xor_pd(v, _mm512_set1_pd(-0.0))); }
  EightPack operator+(EightPack b) const { return EightPack(_mm512_add_pd(v, b.v)); }
  EightPack operator-(EightPack b) const { return EightPack(_mm512_sub_pd(v, b.v)); }
  EightPack operator*(EightPack b) const { return EightPack(_mm512_mul_pd(v, b.v)); }
  EightPack operator/(EightPack b) const { return EightPack(_mm512_div_pd(v, b.v)); }
  EightMask operator<(EightPack b) const { return {_mm512_cmp_pd_mask(v, b.v, _CMP_LT_OQ)}; }

  __m512d v;
};

EightPack fma(EightPack a, EightPack b, EightPack c) {
  return EightPack(_mm512_fmadd_pd(a.v, b.v, c.v));
}
EightPack abs(EightPack a) { return EightPack(_mm512_abs_pd(a.v)); }
EightPack sqrt(EightPack a) { return EightPack(_mm512_sqrt_pd(a.v)); }
EightPack max(EightPack a, EightPack b) { return EightPack(_mm512_max_pd(a.v, b.v)); }
EightPack select(EightMask mask, EightPack a, EightPack b) {
  return EightPack(_mm512_mask_blend_pd(mask.m, b.v, a.v));
}
bool all(EightMask mask) { return mask.m == 0xff; }

// Every so many-th double.
EightPack load_strided(const double* from, long long stride) {
  const __m512i steps = _mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0);
  const __m512i index = _mm512_mullo_epi64(steps, _mm512_set1_epi64(stride));
  return EightPack(_mm512_i64gather_pd(index, from, sizeof(double)));
}

void load_points(const double* from, EightPack& x, EightPack& y, EightPack& z) {
  x = load_strided(from, 3);
  y = load_strided(from + 1, 3);
  z = load_strided(from + 2, 3);
}

void load_pairs(const double* from, EightPack& u, EightPack& v) {
  u = load_strided(from, 2);
  v = load_strided(from + 1, 2);
}

// Rows to columns, four by four.
void load_fours(const double* from, EightPack (&c)[4]) {
  for (int i = 0; i < 4; ++i) c[i] = load_strided(from + i, 4);
}

// The sums over the lanes of four packs.
void store_lane_sums(const EightPack* a, double* to) {
  for (int i = 0; i < 4; ++i) to[i] = _mm512_reduce_add_pd(a[i].v);
}

}  // namespace

constinit const ParameterSumKernels kAvx512ParameterSums = parameter_sums_for<EightPack>();

}  // namespace tagcal::internal

#else

namespace tagcal::internal {

constinit const ParameterSumKernels kAvx512ParameterSums = {};

}  // namespace tagcal::internal

#endif
