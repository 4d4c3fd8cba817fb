#include <cmath>

#include "tagcal/camera/kernels/kernel_table.hpp"

namespace tagcal::internal {
namespace {

struct OneMask {
  OneMask operator&(OneMask b) const { return {m && b.m}; }

  bool m;
};

// One double as a pack.
struct OnePack {
  static constexpr int kSize = 1;
  using Mask = OneMask;

  OnePack() = default;
  explicit OnePack(double value) : v(value) {}

  OnePack operator-() const { return OnePack(-v); }
  OnePack operator+(OnePack b) const { return OnePack(v + b.v); }
  OnePack operator-(OnePack b) const { return OnePack(v - b.v); }
  OnePack operator*(OnePack b) const { return OnePack(v * b.v); }
  OnePack operator/(OnePack b) const { return OnePack(v / b.v); }
  OneMask operator<(OnePack b) const { return {v < b.v}; }

  double v;
};

OnePack fma(OnePack a, OnePack b, OnePack c) { return a * b + c; }  // std::fma is slow without FMA
OnePack abs(OnePack a) { return OnePack(std::abs(a.v)); }
OnePack sqrt(OnePack a) { return OnePack(std::sqrt(a.v)); }
OnePack max(OnePack a, OnePack b) { return a.v > b.v ? a : b; }
OnePack select(OneMask mask, OnePack a, OnePack b) { return mask.m ? a : b; }
OnePack nan_unless(OneMask mask, OnePack a) { return mask.m ? a : OnePack(__builtin_nan("")); }
bool all(OneMask mask) { return mask.m; }

void load_points(const double* from, OnePack& x, OnePack& y, OnePack& z) {
  x.v = from[0];
  y.v = from[1];
  z.v = from[2];
}

void load_pairs(const double* from, OnePack& u, OnePack& v) {
  u.v = from[0];
  v.v = from[1];
}

void load_fours(const double* from, OnePack (&c)[4]) {
  for (int i = 0; i < 4; ++i) c[i].v = from[i];
}

void store_lane_sums(const OnePack* a, double* to) {
  for (int i = 0; i < 4; ++i) to[i] = a[i].v;
}

void store_pixels(OnePack u, OnePack v, double* to) {
  to[0] = u.v;
  to[1] = v.v;
}

void store_valid(OneMask mask, unsigned char* to) { *to = mask.m; }

template <typename Column>
void store_rows(const Column& column, int num_columns, double* to, int) {
  for (int i = 0; i < num_columns; ++i) to[i] = column(i).v;
}

}  // namespace

constinit const ProjectKernels kPortableKernels = kernels_for<OnePack>();

}  // namespace tagcal::internal
