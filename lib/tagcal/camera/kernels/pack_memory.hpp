#pragma once

#include "tagcal/internal/pack.hpp"

// Packs of points, pixels and rows from and to memory. Included by the files of kernels only, each
// of which has its own copy.

namespace tagcal::internal {
namespace {

inline void load_points(const double* from, double& x, double& y, double& z) {
  x = from[0];
  y = from[1];
  z = from[2];
}

inline void load_pairs(const double* from, double& u, double& v) {
  u = from[0];
  v = from[1];
}

// Rows of four to columns.
inline void load_fours(const double* from, double (&c)[4]) {
  for (int i = 0; i < 4; ++i) c[i] = from[i];
}

// The sums over the lanes of four packs.
inline void store_lane_sums(const double* a, double* to) {
  for (int i = 0; i < 4; ++i) to[i] = a[i];
}

inline void store_pixels(double u, double v, double* to) {
  to[0] = u;
  to[1] = v;
}

inline void store_valid(bool mask, unsigned char* to) { *to = mask; }

// Columns to rows, `stride` apart.
template <typename Column>
void store_columns(const Column& column, double, int num_columns, double* to, int) {
  for (int i = 0; i < num_columns; ++i) to[i] = column(i);
}

#ifdef __AVX2__

typedef double Pair __attribute__((vector_size(16)));

// a0 b0 a2 b2 and a1 b1 a3 b3
inline Doubles even(Doubles a, Doubles b) { return __builtin_shufflevector(a, b, 0, 4, 2, 6); }
inline Doubles odd(Doubles a, Doubles b) { return __builtin_shufflevector(a, b, 1, 5, 3, 7); }
// a0 a1 b0 b1 and a2 a3 b2 b3
inline Doubles front(Doubles a, Doubles b) { return __builtin_shufflevector(a, b, 0, 1, 4, 5); }
inline Doubles back(Doubles a, Doubles b) { return __builtin_shufflevector(a, b, 2, 3, 6, 7); }

inline void transpose(Doubles (&c)[4]) {
  const Doubles even01 = even(c[0], c[1]), odd01 = odd(c[0], c[1]);
  const Doubles even23 = even(c[2], c[3]), odd23 = odd(c[2], c[3]);
  c[0] = front(even01, even23);
  c[1] = front(odd01, odd23);
  c[2] = back(even01, even23);
  c[3] = back(odd01, odd23);
}

inline void load_points(const double* from, Doubles& x, Doubles& y, Doubles& z) {
  const auto two_pairs = [from](int low, int high) {
    return __builtin_shufflevector(load<Pair>(from + low), load<Pair>(from + high), 0, 1, 2, 3);
  };
  const Doubles xy = two_pairs(0, 6);   // x0 y0 x2 y2
  const Doubles zx = two_pairs(2, 8);   // z0 x1 z2 x3
  const Doubles yz = two_pairs(4, 10);  // y1 z1 y3 z3
  x = __builtin_shufflevector(xy, zx, 0, 5, 2, 7);
  y = __builtin_shufflevector(xy, yz, 1, 4, 3, 6);
  z = __builtin_shufflevector(zx, yz, 0, 5, 2, 7);
}

inline void load_pairs(const double* from, Doubles& u, Doubles& v) {
  const Doubles low = load<Doubles>(from), high = load<Doubles>(from + 4);
  u = even(front(low, high), back(low, high));
  v = odd(front(low, high), back(low, high));
}

inline void load_fours(const double* from, Doubles (&c)[4]) {
  c[0] = load<Doubles>(from);
  c[1] = load<Doubles>(from + 4);
  c[2] = load<Doubles>(from + 8);
  c[3] = load<Doubles>(from + 12);
  transpose(c);
}

inline void store_lane_sums(const Doubles* a, double* to) {
  const Doubles ab = even(a[0], a[1]) + odd(a[0], a[1]);
  const Doubles cd = even(a[2], a[3]) + odd(a[2], a[3]);
  store(to, front(ab, cd) + back(ab, cd));
}

inline void store_pixels(Doubles u, Doubles v, double* to) {
  store(to, front(even(u, v), odd(u, v)));
  store(to + 4, back(even(u, v), odd(u, v)));
}

// Bit i of the mask becomes byte i.
inline void store_valid(Longs mask, unsigned char* to) {
  const unsigned bits =
      static_cast<unsigned>(_mm256_movemask_pd(__builtin_bit_cast(Doubles, mask)));
  const unsigned bytes = (bits * 0x00204081u) & 0x01010101u;
  __builtin_memcpy(to, &bytes, sizeof bytes);
}

// Four by four, then two by two.
template <typename Column>
void store_columns(const Column& column, Doubles, int num_columns, double* to, int stride) {
  int i = 0;
  for (; i + 4 <= num_columns; i += 4) {
    Doubles rows[4] = {column(i), column(i + 1), column(i + 2), column(i + 3)};
    transpose(rows);
    store(to + i, rows[0]);
    store(to + stride + i, rows[1]);
    store(to + 2 * stride + i, rows[2]);
    store(to + 3 * stride + i, rows[3]);
  }
  for (; i + 2 <= num_columns; i += 2) {
    const Doubles row02 = even(column(i), column(i + 1)), row13 = odd(column(i), column(i + 1));
    store(to + i, __builtin_shufflevector(row02, row02, 0, 1));
    store(to + stride + i, __builtin_shufflevector(row13, row13, 0, 1));
    store(to + 2 * stride + i, __builtin_shufflevector(row02, row02, 2, 3));
    store(to + 3 * stride + i, __builtin_shufflevector(row13, row13, 2, 3));
  }
  if (i == num_columns) return;
  const Doubles last = column(i);
  for (int lane = 0; lane < 4; ++lane) to[lane * stride + i] = last[lane];
}

#endif

template <typename Column>
void store_rows(const Column& column, int num_columns, double* to, int stride) {
  store_columns(column, column(0), num_columns, to, stride);
}

}  // namespace
}  // namespace tagcal::internal
