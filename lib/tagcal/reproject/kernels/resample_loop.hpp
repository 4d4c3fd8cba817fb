#pragma once

#include "tagcal/internal/pack.hpp"
#include "tagcal/reproject/kernels/reproject_kernels.hpp"

// Interpolation in a picture at the coordinates of a row. A coordinate is in the picture if it is
// in [-0.5, width - 0.5) x [-0.5, height - 0.5); taps beyond the border are those at the border.
// Included by the files of kernels only, each of which has its own copy.

namespace tagcal::internal {
namespace {

template <typename T, int kValues>
class Source {
 public:
  explicit Source(const ResampleJob& job)
      : job_(job),
        pixels_(static_cast<const T*>(job.source)),
        target_(static_cast<T*>(job.target)) {
    right_ = static_cast<float>(job.width) - 0.5f;
    bottom_ = static_cast<float>(job.height) - 0.5f;
  }

  // Writes the border where nothing is seen. NaN is not in the picture.
  bool is_seen(long i) const {
    const float x = job_.x[i], y = job_.y[i];
    const bool seen = (x >= -0.5f) & (x < right_) & (y >= -0.5f) & (y < bottom_);
    job_.seen[i] = seen ? 255 : 0;
    if (!seen) {
      const T* const border = static_cast<const T*>(job_.border);
      for (int k = 0; k < kValues; ++k) target_[i * kValues + k] = border[k];
    }
    return seen;
  }

  const T* pixel(int x, int y) const {
    const int in_x = x < 0 ? 0 : x < job_.width ? x : job_.width - 1;
    const int in_y = y < 0 ? 0 : y < job_.height ? y : job_.height - 1;
    return pixels_ + static_cast<long>(in_y) * job_.stride + static_cast<long>(in_x) * kValues;
  }

  // Rounds to the nearest value that the type has.
  void write(long i, const float* values) const {
    constexpr float kMost = sizeof(T) == 1 ? 255.0f : 65535.0f;
    for (int k = 0; k < kValues; ++k) {
      const float v = values[k] + 0.5f;
      target_[i * kValues + k] = static_cast<T>(v < 0 ? 0.0f : v > kMost ? kMost : v);
    }
  }

 private:
  const ResampleJob& job_;
  const T* pixels_;
  T* target_;
  float right_, bottom_;
};

// floor for |x| < 2^31
inline int below(float x) {
  const int i = static_cast<int>(x);
  return i - (x < static_cast<float>(i));
}

template <typename T, int kValues>
void nearest_row(const ResampleJob& job) {
  const Source<T, kValues> source(job);
  T* const target = static_cast<T*>(job.target);
  for (long i = 0; i < job.num_pixels; ++i) {
    if (!source.is_seen(i)) continue;
    const T* const from = source.pixel(below(job.x[i] + 0.5f), below(job.y[i] + 0.5f));
    for (int k = 0; k < kValues; ++k) target[i * kValues + k] = from[k];
  }
}

template <typename T, int kValues>
void bilinear_pixel(const ResampleJob& job, const Source<T, kValues>& source, long i) {
  if (!source.is_seen(i)) return;
  const int x = below(job.x[i]), y = below(job.y[i]);
  const float fx = job.x[i] - static_cast<float>(x), fy = job.y[i] - static_cast<float>(y);
  const T* const p00 = source.pixel(x, y);
  const T* const p10 = source.pixel(x + 1, y);
  const T* const p01 = source.pixel(x, y + 1);
  const T* const p11 = source.pixel(x + 1, y + 1);
  float values[kValues];
  for (int k = 0; k < kValues; ++k) {
    const float a = p00[k], b = p10[k], c = p01[k], d = p11[k];
    const float top = a + fx * (b - a), bottom = c + fx * (d - c);
    values[k] = top + fy * (bottom - top);
  }
  source.write(i, values);
}

#ifdef __AVX2__

inline Ints gather(const char* base, Ints offsets) {
  const __m256i bits = _mm256_i32gather_epi32(reinterpret_cast<const int*>(base),
                                              __builtin_bit_cast(__m256i, offsets), 1);
  return __builtin_bit_cast(Ints, bits);
}

inline Floats floats(Ints values) { return __builtin_convertvector(values, Floats); }

// Value k of the pixels at byte offsets `at`, and of their neighbours on the right. The words that
// are read end with the neighbour, or one or two bytes of grey behind it.
template <typename T, int kValues>
struct Pair;

template <>
struct Pair<unsigned char, 1> {
  Pair(const char* base, Ints at) : word(gather(base, at)) {}
  Floats left(int) const { return floats(word & 255); }
  Floats right(int) const { return floats((word >> 8) & 255); }
  Ints word;
};

template <>
struct Pair<unsigned short, 1> {
  Pair(const char* base, Ints at) : word(gather(base, at)) {}
  Floats left(int) const { return floats(word & 65535); }
  Floats right(int) const { return floats((word >> 16) & 65535); }
  Ints word;
};

template <>
struct Pair<unsigned char, 3> {
  Pair(const char* base, Ints at) : first(gather(base, at)), last(gather(base, at + 2)) {}
  Floats left(int k) const { return floats((first >> (8 * k)) & 255); }
  Floats right(int k) const { return floats((last >> (8 * k + 8)) & 255); }
  Ints first, last;
};

template <>
struct Pair<unsigned short, 3> {
  Pair(const char* base, Ints at)
      : words{gather(base, at), gather(base, at + 4), gather(base, at + 8)} {}
  Floats value(int k) const { return floats((words[k / 2] >> (16 * (k % 2))) & 65535); }
  Floats left(int k) const { return value(k); }
  Floats right(int k) const { return value(k + 3); }
  Ints words[3];
};

// Stores eight pixels of rounded values.
inline void store_pixels(unsigned char* to, const Ints (&v)[1]) {
  for (int half = 0; half < 2; ++half) {
    const __m256i all = __builtin_bit_cast(__m256i, v[0]);
    const __m128i four = half == 0 ? _mm256_castsi256_si128(all) : _mm256_extracti128_si256(all, 1);
    const __m128i bytes = _mm_shuffle_epi8(
        four, _mm_setr_epi8(0, 4, 8, 12, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1));
    const int word = _mm_cvtsi128_si32(bytes);
    __builtin_memcpy(to + 4 * half, &word, 4);
  }
}

inline void store_pixels(unsigned short* to, const Ints (&v)[1]) {
  typedef unsigned short Shorts __attribute__((vector_size(16)));
  const Shorts shorts = __builtin_convertvector(v[0], Shorts);
  __builtin_memcpy(to, &shorts, sizeof shorts);
}

inline void store_pixels(unsigned char* to, const Ints (&v)[3]) {
  const __m256i words = __builtin_bit_cast(__m256i, v[0] | (v[1] << 8) | (v[2] << 16));
  const __m256i order = _mm256_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1, 0,
                                         1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
  const __m256i packed = _mm256_shuffle_epi8(words, order);
  char bytes[32];
  __builtin_memcpy(bytes, &packed, sizeof bytes);
  __builtin_memcpy(to, bytes, 12);
  __builtin_memcpy(to + 12, bytes + 16, 12);
}

inline void store_pixels(unsigned short* to, const Ints (&v)[3]) {
  for (int lane = 0; lane < 8; ++lane)
    for (int k = 0; k < 3; ++k) to[3 * lane + k] = static_cast<unsigned short>(v[k][lane]);
}

// Eight pixels from `i`, if the four neighbours of each are in the picture and have a row below
// them, whose memory may be read too. Otherwise returns false.
template <typename T, int kValues>
bool bilinear_pack(const ResampleJob& job, long i) {
  const Floats x = load<Floats>(job.x + i), y = load<Floats>(job.y + i);
  const float right = static_cast<float>(job.width - 1),
              bottom = static_cast<float>(job.height - 2);
  const Ints inside = (x >= 0.0f) & (x < right) & (y >= 0.0f) & (y < bottom);
  if (_mm256_movemask_ps(__builtin_bit_cast(__m256, inside)) != 255) return false;
  const Ints column = __builtin_convertvector(x, Ints), row = __builtin_convertvector(y, Ints);
  const Floats fx = x - floats(column), fy = y - floats(row);
  constexpr int kSize = sizeof(T);
  const int stride = static_cast<int>(job.stride) * kSize;
  const Ints at = row * stride + column * (kSize * kValues);
  const char* const base = static_cast<const char*>(job.source);
  const Pair<T, kValues> upper(base, at), lower(base + stride, at);
  Ints values[kValues];
  for (int k = 0; k < kValues; ++k) {
    const Floats a = upper.left(k), c = lower.left(k);
    const Floats top = a + fx * (upper.right(k) - a), under = c + fx * (lower.right(k) - c);
    values[k] = __builtin_convertvector(top + fy * (under - top) + 0.5f, Ints);
  }
  store_pixels(static_cast<T*>(job.target) + i * kValues, values);
  __builtin_memset(job.seen + i, 255, 8);
  return true;
}

// Offsets in bytes are 32-bit.
inline bool has_packs(const ResampleJob& job, int value_size) {
  return job.stride * value_size * job.height < 2147483647L;
}

#else

template <typename T, int kValues>
bool bilinear_pack(const ResampleJob&, long) {
  return false;
}
inline bool has_packs(const ResampleJob&, int) { return false; }

#endif

template <typename T, int kValues>
void bilinear_row(const ResampleJob& job) {
  const Source<T, kValues> source(job);
  long i = 0;
  if (has_packs(job, sizeof(T))) {
    for (; i + 8 <= job.num_pixels; i += 8) {
      if (bilinear_pack<T, kValues>(job, i)) continue;
      for (long j = i; j < i + 8; ++j) bilinear_pixel<T, kValues>(job, source, j);
    }
  }
  for (; i < job.num_pixels; ++i) bilinear_pixel<T, kValues>(job, source, i);
}

// The weights at a fraction of a pixel, between those of two phases.
inline void lanczos_weights(const float* phases, float fraction, float* weights) {
  const float position = fraction * kPhases;
  const int phase = static_cast<int>(position);
  const float share = position - static_cast<float>(phase);
  const float* const row = phases + phase * kLanczosTaps;
  for (int k = 0; k < kLanczosTaps; ++k)
    weights[k] = row[k] + share * (row[k + kLanczosTaps] - row[k]);
}

// Sums over the rows and columns of taps of which some are beyond the border.
template <typename T, int kValues>
void lanczos_at_border(const Source<T, kValues>& source, int x, int y, const float* wx,
                       const float* wy, float* values) {
  for (int k = 0; k < kValues; ++k) values[k] = 0;
  for (int j = 0; j < kLanczosTaps; ++j)
    for (int i = 0; i < kLanczosTaps; ++i)
      for (int k = 0; k < kValues; ++k)
        values[k] += wx[i] * wy[j] * static_cast<float>(source.pixel(x - 3 + i, y - 3 + j)[k]);
}

#ifdef __AVX2__

inline Floats load_as_floats(const unsigned char* from) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
}
inline Floats load_as_floats(const unsigned short* from) {
  const __m128i shorts = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  return _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(shorts));
}

inline float lane_sum(Floats v) {
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
}

// The same where all taps are in the picture.
template <typename T, int kValues>
void lanczos_inside(const Source<T, kValues>& source, const ResampleJob& job, int x, int y,
                    const float* wx, const float* wy, float* values) {
  Floats sums[kValues] = {};
  const T* row = source.pixel(x - 3, y - 3);
  for (int j = 0; j < kLanczosTaps; ++j, row += job.stride)
    for (int k = 0; k < kValues; ++k) sums[k] += wy[j] * load_as_floats(row + 8 * k);
  if constexpr (kValues == 1) {
    values[0] = lane_sum(sums[0] * load<Floats>(wx));
  } else {
    float flat[8 * kValues];
    __builtin_memcpy(flat, sums, sizeof flat);
    for (int k = 0; k < kValues; ++k) {
      values[k] = 0;
      for (int i = 0; i < kLanczosTaps; ++i) values[k] += wx[i] * flat[i * kValues + k];
    }
  }
}

#else

template <typename T, int kValues>
void lanczos_inside(const Source<T, kValues>& source, const ResampleJob&, int x, int y,
                    const float* wx, const float* wy, float* values) {
  lanczos_at_border<T, kValues>(source, x, y, wx, wy, values);
}

#endif

template <typename T, int kValues>
void lanczos_row(const ResampleJob& job) {
  const Source<T, kValues> source(job);
  for (long i = 0; i < job.num_pixels; ++i) {
    if (!source.is_seen(i)) continue;
    const int x = below(job.x[i]), y = below(job.y[i]);
    float wx[kLanczosTaps], wy[kLanczosTaps], values[kValues];
    lanczos_weights(job.phases, job.x[i] - static_cast<float>(x), wx);
    lanczos_weights(job.phases, job.y[i] - static_cast<float>(y), wy);
    const bool inner = x >= 3 && y >= 3 && x + 4 < job.width && y + 4 < job.height;
    if (inner)
      lanczos_inside(source, job, x, y, wx, wy, values);
    else
      lanczos_at_border(source, x, y, wx, wy, values);
    source.write(i, values);
  }
}

}  // namespace
}  // namespace tagcal::internal
