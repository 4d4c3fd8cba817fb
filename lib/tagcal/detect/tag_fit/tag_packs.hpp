#pragma once

#include "tagcal/detect/tag_fit/tag_kernels.hpp"
#include "tagcal/internal/pack.hpp"

// Functions of packs for the loops of tag_kernels.hpp. Included by the files of kernels only.
namespace tagcal::internal {
namespace {

using Pack = Floats;
using IntPack = Ints;
using BitPack = Bits;
static_assert(kTagPack % kFloatLanes == 0);

// Natural logarithm of a positive number, with an error below 1e-6.
inline Pack logarithm(Pack x) {
  const IntPack bits = __builtin_bit_cast(IntPack, x);
  // The mantissa m lies in [2/3, 4/3).
  const IntPack exponent = (bits - 0x3f2aaaab) >> 23;
  const Pack m = __builtin_bit_cast(Pack, bits - (exponent << 23));
  const Pack t = (m - 1.0F) / (m + 1.0F), t2 = t * t;
  // numeric: log 2 times the exponent, plus log m = 2 artanh t
  return 0.693147181F * __builtin_convertvector(exponent, Pack) +
         // numeric: series of artanh
         2.0F * t * (1.0F + t2 * (0.333333333F + t2 * (0.2F + t2 * 0.142857143F)));
}

// exp(-a) for 0 <= a <= 80, with a relative error below 6e-6.
inline Pack exp_minus(Pack a) {
  // numeric: 1 / log 2; the 100 makes t positive, so that truncation is floor
  const Pack t = 100.0F - a * 1.44269504F;
  const IntPack whole = __builtin_convertvector(t, IntPack);
  const Pack f = t - __builtin_convertvector(whole, Pack);
  const Pack power =
      1.0F +
      // numeric: series of 2^f, its coefficients (log 2)^n / n!
      f * (0.693147182F + f * (0.240226463F + f * (0.0555041F + f * (0.00961813F + f * 0.00133336F +
                                                                     // numeric: as above
                                                                     f * f * 0.000154035F))));
  return power * __builtin_bit_cast(Pack, (whole + 27) << 23);
}

// Adds the sum over the lanes of each of four packs.
inline void add_sums(const Pack* packs, double* sums) {
#ifdef __AVX2__
  const __m256 all =
      _mm256_hadd_ps(_mm256_hadd_ps(packs[0], packs[1]), _mm256_hadd_ps(packs[2], packs[3]));
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1));
  _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), _mm256_cvtps_pd(four)));
#else
  for (int j = 0; j < 4; ++j) {
    float sum = 0;
    for (int lane = 0; lane < kFloatLanes; ++lane) sum += packs[j][lane];
    sums[j] += static_cast<double>(sum);
  }
#endif
}

inline bool any_set(IntPack mask) {
#ifdef __AVX2__
  return _mm256_testz_si256(__builtin_bit_cast(__m256i, mask), __builtin_bit_cast(__m256i, mask)) ==
         0;
#else
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
#endif
}

inline BitPack gather(const std::uint32_t* values, IntPack index) {
#ifdef __AVX2__
  return __builtin_bit_cast(
      BitPack, _mm256_i32gather_epi32(reinterpret_cast<const int*>(values),
                                      __builtin_bit_cast(__m256i, index), sizeof *values));
#else
  BitPack result;
  for (int i = 0; i < kFloatLanes; ++i) result[i] = values[index[i]];
  return result;
#endif
}

// A line for each pixel of a pack.
struct LinePack {
  Pack by_x, by_y, by_1, at, inv_length;
};

inline LinePack load_lines(const TagLine* lines, const std::int32_t* first) {
#ifdef __AVX2__
  // Transposes rows of eight numbers.
  __m256 r[8], s[8];
  for (int i = 0; i < 8; ++i) r[i] = _mm256_load_ps(&lines[first[i]].by_x);
  for (int i = 0; i < 4; ++i) {
    s[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
    s[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
  }
  for (int i = 0; i < 8; i += 4) {
    r[i] = _mm256_shuffle_ps(s[i], s[i + 2], 0x44);
    r[i + 1] = _mm256_shuffle_ps(s[i], s[i + 2], 0xee);
    r[i + 2] = _mm256_shuffle_ps(s[i + 1], s[i + 3], 0x44);
  }
  return {_mm256_permute2f128_ps(r[0], r[4], 0x20), _mm256_permute2f128_ps(r[1], r[5], 0x20),
          _mm256_permute2f128_ps(r[2], r[6], 0x20),
          _mm256_permute2f128_ps(_mm256_shuffle_ps(s[1], s[3], 0xee),
                                 _mm256_shuffle_ps(s[5], s[7], 0xee), 0x20),
          _mm256_permute2f128_ps(r[0], r[4], 0x31)};
#else
  LinePack pack;
  for (int i = 0; i < kFloatLanes; ++i) {
    const TagLine& line = lines[first[i]];
    pack.by_x[i] = line.by_x;
    pack.by_y[i] = line.by_y;
    pack.by_1[i] = line.by_1;
    pack.at[i] = line.at;
    pack.inv_length[i] = line.inv_length;
  }
  return pack;
#endif
}

// Share of white in grey levels from that in light; multiplies `gain` by its derivative.
inline Pack grey_of_light(const TagTable& table, Pack white, Pack& gain) {
  const Pack least = splat<Pack>(1e-3F);  // numeric: keeps the logarithm finite
  const Pack light = table.black_light + (1.0F - table.black_light) * white;
  const Pack x = larger(light, least);
  const Pack grey = exp_minus(-table.gamma * logarithm(x));
  const Pack stretch = splat<Pack>(1.0F / (1.0F - table.black_grey));
  gain *= stretch * table.gamma * (1.0F - table.black_light) * grey / x;
  return stretch * (grey - table.black_grey);
}

// All bits set where a level is at an end of its range and the model beyond it: the pixel says
// nothing more. Moves a level that is a bound back towards the range.
inline IntPack is_clipped(const TagTable& table, Pack& level, Pack model) {
  const Pack zero = {}, beyond = zero + table.beyond;
  const IntPack is_least = level >= table.full_level, is_most = level <= table.least_level;
  level += is_most ? beyond : is_least ? -beyond : zero;
  return (is_least & (model > level)) | (is_most & (model < level));
}

}  // namespace
}  // namespace tagcal::internal
