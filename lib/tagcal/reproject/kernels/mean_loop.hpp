#pragma once

#include "tagcal/reproject/kernels/resample_loop.hpp"

// Means with a widened kernel of up to 16 x 16 taps, all in the picture. Included by the files of
// kernels only, each of which has its own copy.

namespace tagcal::internal {
namespace {

#ifdef __AVX2__

struct MeanTaps {
  int first = 0;
  int count = 0;
  float weights[16];
};

// Weights by the distance in widths: of a tent, or of Lanczos by its table.
template <bool kLanczos>
inline Floats mean_weights(Floats distance, const float* profile) {
  if constexpr (!kLanczos) return larger(1.0f - distance, Floats{});
  const Floats position = (distance < 4.0f ? distance : Floats{} + 4.0f) * float{kProfileSteps};
  const Ints step = __builtin_convertvector(position, Ints);
  const Floats share = position - floats(step);
  const char* const base = reinterpret_cast<const char*>(profile);
  const Floats a = __builtin_bit_cast(Floats, gather(base, step * 4));
  const Floats b = __builtin_bit_cast(Floats, gather(base + 4, step * 4));
  return a + share * (b - a);
}

// False for more than 16 taps. The weights sum to 1; those behind `count` are 0.
template <bool kLanczos>
inline bool set_taps(float centre, float width, const float* profile, MeanTaps& taps) {
  const float reach = (kLanczos ? 4.0f : 1.0f) * width;
  taps.first = below(centre - reach) + 1;
  taps.count = -below(-(centre + reach)) - taps.first;
  if (taps.count > 16) return false;
  const Floats lanes = {0, 1, 2, 3, 4, 5, 6, 7};
  const float per_width = 1 / width, offset = static_cast<float>(taps.first) - centre;
  const Floats low = mean_weights<kLanczos>(magnitude((lanes + offset) * per_width), profile);
  Floats high = {};
  if (taps.count > 8)
    high = mean_weights<kLanczos>(magnitude((lanes + (offset + 8)) * per_width), profile);
  const float scale = 1 / lane_sum(low + high);
  store(taps.weights, low * scale);
  store(taps.weights + 8, high * scale);
  return true;
}

template <typename T, int kValues, int kBlocks>
inline void mean_sums(const ResampleJob& job, const T* row, const MeanTaps& across,
                      const MeanTaps& down, float* values) {
  Floats sums[kBlocks * kValues] = {};
  for (int j = 0; j < down.count; ++j, row += job.stride)
    for (int k = 0; k < kBlocks * kValues; ++k)
      sums[k] += down.weights[j] * load_as_floats(row + 8 * k);
  if constexpr (kValues == 1) {
    Floats sum = {};
    for (int k = 0; k < kBlocks; ++k) sum += sums[k] * load<Floats>(across.weights + 8 * k);
    values[0] = lane_sum(sum);
  } else {
    float flat[8 * kBlocks * kValues];
    __builtin_memcpy(flat, sums, sizeof flat);
    for (int k = 0; k < kValues; ++k) {
      values[k] = 0;
      for (int i = 0; i < across.count; ++i) values[k] += across.weights[i] * flat[i * kValues + k];
    }
  }
}

template <typename T, int kValues, bool kLanczos>
bool mean_pixel(const ResampleJob& job, long i, float width) {
  MeanTaps across, down;
  if (!set_taps<kLanczos>(job.x[i], width, job.profile, across) ||
      !set_taps<kLanczos>(job.y[i], width, job.profile, down))
    return false;
  const int read = across.count > 8 ? 16 : 8;
  if (across.first < 0 || across.first + read > job.width || down.first < 0 ||
      down.first + down.count > job.height)
    return false;
  const Source<T, kValues> source(job);
  const T* const row = source.pixel(across.first, down.first);
  float values[kValues];
  if (read == 8)
    mean_sums<T, kValues, 1>(job, row, across, down, values);
  else
    mean_sums<T, kValues, 2>(job, row, across, down, values);
  source.write(i, values);
  return true;
}

#else

template <typename T, int kValues, bool kLanczos>
bool mean_pixel(const ResampleJob&, long, float) {
  return false;
}

#endif

}  // namespace
}  // namespace tagcal::internal
