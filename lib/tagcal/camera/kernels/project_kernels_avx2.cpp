// Compiled with -mavx2 -mfma on x86-64 (lib/CMakeLists.txt); see project_kernels.hpp for what must
// not be included here. Everywhere else there are no such kernels.
#include "tagcal/camera/kernels/project_kernels.hpp"

#if defined(__AVX2__) && defined(__FMA__)

#include <immintrin.h>

#include "tagcal/camera/kernels/kernel_table.hpp"

namespace tagcal::internal {
namespace {

struct FourMask {
  FourMask operator&(FourMask b) const { return {_mm256_and_pd(m, b.m)}; }

  __m256d m;
};

// Four doubles in a register.
struct FourPack {
  static constexpr int kSize = 4;
  using Mask = FourMask;

  FourPack() = default;
  explicit FourPack(double value) : v(_mm256_set1_pd(value)) {}
  explicit FourPack(__m256d values) : v(values) {}

  FourPack operator-() const { return FourPack(_mm256_xor_pd(v, _mm256_set1_pd(-0.0))); }
  FourPack operator+(FourPack b) const { return FourPack(_mm256_add_pd(v, b.v)); }
  FourPack operator-(FourPack b) const { return FourPack(_mm256_sub_pd(v, b.v)); }
  FourPack operator*(FourPack b) const { return FourPack(_mm256_mul_pd(v, b.v)); }
  FourPack operator/(FourPack b) const { return FourPack(_mm256_div_pd(v, b.v)); }
  FourMask operator<(FourPack b) const { return {_mm256_cmp_pd(v, b.v, _CMP_LT_OQ)}; }

  __m256d v;
};

FourPack fma(FourPack a, FourPack b, FourPack c) {
  return FourPack(_mm256_fmadd_pd(a.v, b.v, c.v));
}
FourPack abs(FourPack a) { return FourPack(_mm256_andnot_pd(_mm256_set1_pd(-0.0), a.v)); }
FourPack sqrt(FourPack a) { return FourPack(_mm256_sqrt_pd(a.v)); }
FourPack max(FourPack a, FourPack b) { return FourPack(_mm256_max_pd(a.v, b.v)); }
FourPack select(FourMask mask, FourPack a, FourPack b) {
  return FourPack(_mm256_blendv_pd(b.v, a.v, mask.m));
}
FourPack nan_unless(FourMask mask, FourPack a) {
  const __m256d ones = _mm256_castsi256_pd(_mm256_set1_epi64x(-1));  // a NaN
  return FourPack(_mm256_or_pd(a.v, _mm256_xor_pd(mask.m, ones)));
}
bool all(FourMask mask) { return _mm256_movemask_pd(mask.m) == 15; }

// x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3 -> x0 x1 x2 x3, ...
void load_points(const double* from, FourPack& x, FourPack& y, FourPack& z) {
  const auto two_pairs = [from](int low, int high) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(from + low)),
                                _mm_loadu_pd(from + high), 1);
  };
  const __m256d xy = two_pairs(0, 6);   // x0 y0 x2 y2
  const __m256d zx = two_pairs(2, 8);   // z0 x1 z2 x3
  const __m256d yz = two_pairs(4, 10);  // y1 z1 y3 z3
  x.v = _mm256_shuffle_pd(xy, zx, 0b1010);
  y.v = _mm256_shuffle_pd(xy, yz, 0b0101);
  z.v = _mm256_shuffle_pd(zx, yz, 0b1010);
}

// u0 v0 u1 v1, u2 v2 u3 v3 -> u0 u1 u2 u3, v0 v1 v2 v3
void load_pairs(const double* from, FourPack& u, FourPack& v) {
  const __m256d low = _mm256_loadu_pd(from), high = _mm256_loadu_pd(from + 4);
  const __m256d even = _mm256_permute2f128_pd(low, high, 0x20);  // u0 v0 u2 v2
  const __m256d odd = _mm256_permute2f128_pd(low, high, 0x31);   // u1 v1 u3 v3
  u.v = _mm256_unpacklo_pd(even, odd);
  v.v = _mm256_unpackhi_pd(even, odd);
}

// Rows to columns, four by four.
void load_fours(const double* from, FourPack (&c)[4]) {
  const __m256d row[4] = {_mm256_loadu_pd(from), _mm256_loadu_pd(from + 4),
                          _mm256_loadu_pd(from + 8), _mm256_loadu_pd(from + 12)};
  const __m256d even01 = _mm256_unpacklo_pd(row[0], row[1]);
  const __m256d odd01 = _mm256_unpackhi_pd(row[0], row[1]);
  const __m256d even23 = _mm256_unpacklo_pd(row[2], row[3]);
  const __m256d odd23 = _mm256_unpackhi_pd(row[2], row[3]);
  c[0].v = _mm256_permute2f128_pd(even01, even23, 0x20);
  c[1].v = _mm256_permute2f128_pd(odd01, odd23, 0x20);
  c[2].v = _mm256_permute2f128_pd(even01, even23, 0x31);
  c[3].v = _mm256_permute2f128_pd(odd01, odd23, 0x31);
}

// The sums over the lanes of four packs.
void store_lane_sums(const FourPack* a, double* to) {
  const __m256d ab = _mm256_hadd_pd(a[0].v, a[1].v);  // a0+a1 b0+b1 a2+a3 b2+b3
  const __m256d cd = _mm256_hadd_pd(a[2].v, a[3].v);
  const __m256d low = _mm256_permute2f128_pd(ab, cd, 0x20);
  const __m256d high = _mm256_permute2f128_pd(ab, cd, 0x31);
  _mm256_storeu_pd(to, _mm256_add_pd(low, high));
}

void store_pixels(FourPack u, FourPack v, double* to) {
  const __m256d even = _mm256_unpacklo_pd(u.v, v.v);  // u0 v0 u2 v2
  const __m256d odd = _mm256_unpackhi_pd(u.v, v.v);   // u1 v1 u3 v3
  _mm256_storeu_pd(to, _mm256_permute2f128_pd(even, odd, 0x20));
  _mm256_storeu_pd(to + 4, _mm256_permute2f128_pd(even, odd, 0x31));
}

// Bit i of the mask becomes byte i.
void store_valid(FourMask mask, unsigned char* to) {
  const unsigned bits = static_cast<unsigned>(_mm256_movemask_pd(mask.m));
  const unsigned bytes = (bits * 0x00204081u) & 0x01010101u;
  __builtin_memcpy(to, &bytes, sizeof bytes);
}

// Columns to rows: four by four, then two by two.
void store_four(const FourPack (&c)[4], double* to, int stride) {
  const __m256d even01 = _mm256_unpacklo_pd(c[0].v, c[1].v);
  const __m256d odd01 = _mm256_unpackhi_pd(c[0].v, c[1].v);
  const __m256d even23 = _mm256_unpacklo_pd(c[2].v, c[3].v);
  const __m256d odd23 = _mm256_unpackhi_pd(c[2].v, c[3].v);
  _mm256_storeu_pd(to, _mm256_permute2f128_pd(even01, even23, 0x20));
  _mm256_storeu_pd(to + stride, _mm256_permute2f128_pd(odd01, odd23, 0x20));
  _mm256_storeu_pd(to + 2 * stride, _mm256_permute2f128_pd(even01, even23, 0x31));
  _mm256_storeu_pd(to + 3 * stride, _mm256_permute2f128_pd(odd01, odd23, 0x31));
}

void store_two(FourPack a, FourPack b, double* to, int stride) {
  const __m256d even = _mm256_unpacklo_pd(a.v, b.v);
  const __m256d odd = _mm256_unpackhi_pd(a.v, b.v);
  _mm_storeu_pd(to, _mm256_castpd256_pd128(even));
  _mm_storeu_pd(to + stride, _mm256_castpd256_pd128(odd));
  _mm_storeu_pd(to + 2 * stride, _mm256_extractf128_pd(even, 1));
  _mm_storeu_pd(to + 3 * stride, _mm256_extractf128_pd(odd, 1));
}

template <typename Column>
void store_rows(const Column& column, int num_columns, double* to, int stride) {
  int i = 0;
  for (; i + 4 <= num_columns; i += 4)
    store_four({column(i), column(i + 1), column(i + 2), column(i + 3)}, to + i, stride);
  for (; i + 2 <= num_columns; i += 2) store_two(column(i), column(i + 1), to + i, stride);
  if (i == num_columns) return;
  double lanes[4];
  _mm256_storeu_pd(lanes, column(i).v);
  for (int lane = 0; lane < 4; ++lane) to[lane * stride + i] = lanes[lane];
}

}  // namespace

constinit const ProjectKernels kAvx2Kernels = kernels_for<FourPack>();

}  // namespace tagcal::internal

#else

namespace tagcal::internal {

constinit const ProjectKernels kAvx2Kernels = {};

}  // namespace tagcal::internal

#endif
