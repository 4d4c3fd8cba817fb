#pragma once

#include "tagcal/detect/refine_tag_kernels.hpp"

// The loops of refine_tag_kernels.hpp. Included by the files of kernels only.
namespace tagcal {
namespace {

// exp(-a) for 0 <= a <= 80, to 6e-6 of itself, without branches.
inline float exp_minus(float a) {
  const float t = 100.0F - a * 1.44269504F;  // positive, so that truncation is floor
  const int whole = static_cast<int>(t);
  const float f = t - static_cast<float>(whole);
  const float power =
      1.0F +
      f * (0.693147182F + f * (0.240226463F + f * (0.0555041F + f * (0.00961813F + f * 0.00133336F +
                                                                     f * f * 0.000154035F))));
  return power * __builtin_bit_cast(float, (whole + 27) << 23);
}

// Normal integral (Abramowitz & Stegun 7.1.26) and density, each to 3e-6, without branches.
inline void profile_line(const TagProfileJob& job) {
  const float *const x = job.x, *const y = job.y;
  const float by_x = job.by_x, by_y = job.by_y, by_1 = job.by_1, box = job.box;
  float *const distance = job.distance, *const density = job.density;
  float *const step = job.step, *const slope = job.slope;
  for (int c = job.from; c < job.to; ++c) distance[c] = by_x * x[c] + by_y * y[c] + by_1;
  if (job.xx != nullptr) {
    const float n_x = job.normal_x, n_y = job.normal_y;
    float* const factor = job.factor;
    for (int c = job.from; c < job.to; ++c) {
      const float squared =
          n_x * n_x * job.xx[c] + 2 * n_x * n_y * job.xy[c] + n_y * n_y * job.yy[c];
      factor[c] = 1 / __builtin_sqrtf(squared);
      distance[c] *= factor[c];
    }
  }
#pragma GCC ivdep
  for (int c = job.from; c < job.to; ++c) {
    const float z = distance[c];
    const float size = __builtin_fabsf(z);
    const float a = size < 12.0F ? size : 12.0F;
    const float e = exp_minus(0.5F * a * a);
    const float t = 1.0F / (1.0F + 0.231641888F * a);
    const float tail =
        0.5F * e * t *
        (0.254829592F +
         t * (-0.284496736F + t * (1.421413741F + t * (-1.453152027F + t * 1.061405429F))));
    const float normal = 0.5F + __builtin_copysignf(0.5F - tail, z);
    const float height = 0.398942280F * e;
    const float z2 = z * z;
    density[c] = height;
    step[c] = normal - box * z * (z2 - 3) * height;
    slope[c] = height * (1 + box * (z2 * (z2 - 6) + 3));
  }
}

// Vectors of floats of the compiler: any processor has them, in its own registers or in several.
template <int kLanes>
struct FloatPack {
  typedef float Type __attribute__((vector_size(4 * kLanes)));

  static Type load(const float* from) {
    Type result;
    __builtin_memcpy(&result, from, sizeof result);
    return result;
  }
};

template <int kLanes>
inline void gram_tile(const float* a, const float* b, int stride, int size, float* products) {
  using Pack = FloatPack<kLanes>;
  typename Pack::Type sums[2][4] = {};
  for (int c = 0; c < size; c += kLanes) {
    const typename Pack::Type a0 = Pack::load(a + c), a1 = Pack::load(a + stride + c);
    for (int j = 0; j < 4; ++j) {
      const typename Pack::Type b_j = Pack::load(b + j * stride + c);
      sums[0][j] += a0 * b_j;
      sums[1][j] += a1 * b_j;
    }
  }
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 4; ++j) {
      float sum = 0;
      for (int lane = 0; lane < kLanes; ++lane) sum += sums[i][j][lane];
      products[i * kTagGramRows + j] = sum;
    }
  }
}

template <int kLanes>
void gram(const float* vectors, int stride, int count, int size, float* products) {
  for (int i = 0; i < count; i += 2)
    for (int j = 0; j <= i + 1; j += 4)
      gram_tile<kLanes>(vectors + i * stride, vectors + j * stride, stride, size,
                        products + i * kTagGramRows + j);
}

}  // namespace
}  // namespace tagcal
