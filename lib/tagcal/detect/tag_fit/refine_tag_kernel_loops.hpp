#pragma once

#include "tagcal/detect/tag_fit/refine_tag_border_shifts.hpp"
#include "tagcal/detect/tag_fit/refine_tag_felt_lines.hpp"
#include "tagcal/detect/tag_fit/refine_tag_kernels.hpp"
#include "tagcal/detect/tag_fit/refine_tag_packs.hpp"

// The loops of refine_tag_kernels.hpp. Included by the files of kernels only.
namespace tagcal::internal {
namespace {

// Derivatives of white by a row of the homography's matrix.
struct ByHomography {
  Pack by_x = {}, by_y = {}, by_1 = {};
};

struct ByGeometry {
  ByHomography columns, rows;
  Pack by_last_x = {}, by_last_y = {}, by_log_spread = {}, by_place_x = {}, by_place_y = {};
  ByShift shifts;
};

inline void differentiate(const TagTable& table, const PixelPack& pixel, const FeltLine& felt,
                          ByHomography& by, ByGeometry& all) {
  const Pack by_distance = felt.by_distance * felt.stretched;
  const Pack by_1 = by_distance * felt.line.inv_length * table.per_unit;
  const Pack about = felt.by_distance * felt.distance;
  const Pack turned = about * felt.line.inv_length;
  const Pack by_x = by_1 * pixel.x - turned * felt.normal_x;
  const Pack by_y = by_1 * pixel.y - turned * felt.normal_y;
  by.by_x += by_x;
  by.by_y += by_y;
  by.by_1 += by_1;
  all.by_last_x -= felt.line.at * by_x;
  all.by_last_y -= felt.line.at * by_y;
  all.by_log_spread -= about;
  all.by_place_x += by_distance * felt.line.by_x;
  all.by_place_y += by_distance * felt.line.by_y;
}

inline void put(TagBlock& block, int column, int at, Pack values) {
  store(&block.derivatives[column][at], values);
}

inline void put_bends(TagBlock& block, int at, Pack by_x, Pack by_y) {
  const Pack x = load<Pack>(&block.raw_x[at]), y = load<Pack>(&block.raw_y[at]);
  const Pack xx = x * x, xy = x * y, yy = y * y;
  int column = kTagResidual + 3;
  put(block, column++, at, by_x * yy);
  put(block, column++, at, by_y * xx);
  put(block, column++, at, by_x * xx - by_y * xy);
  put(block, column++, at, by_x * xy - by_y * yy);
  const Pack both[2] = {by_x, by_y};
  for (const Pack by : both) {
    put(block, column++, at, by * x * xx);
    put(block, column++, at, by * x * xy);
    put(block, column++, at, by * x * yy);
    put(block, column++, at, by * y * yy);
  }
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

inline void put_derivatives(const TagTable& table, TagBlock& block, int at, Pack white,
                            const ByGeometry& by) {
  const Pack x = load<Pack>(&block.raw_x[at]), y = load<Pack>(&block.raw_y[at]);
  const Pack contrast = table.gain + table.gain_by_x * x + table.gain_by_y * y;
  Pack gain = contrast;
  if (table.gamma != 1.0F) white = grey_of_light(table, white, gain);
  int column = 0;
  const ByHomography* const parts[2] = {&by.columns, &by.rows};
  for (const ByHomography* part : parts) {
    put(block, column++, at, gain * part->by_x);
    put(block, column++, at, gain * part->by_y);
    put(block, column++, at, gain * part->by_1);
  }
  put(block, column++, at, gain * by.by_last_x);
  put(block, column++, at, gain * by.by_last_y);
  put(block, column++, at, gain * by.by_log_spread);
  put(block, column++, at, splat<Pack>(1.0F));
  put(block, column++, at, white);
  put(block, column++, at, white * x);
  put(block, column++, at, white * y);
  put(block, column++, at, load<Pack>(&block.level[at]) - table.black - contrast * white);
  put(block, column++, at, gain * table.per_px * by.shifts.by_shift);
  put(block, column, at, gain * table.per_px * by.shifts.by_shift_on_tag);
  if (block.is_bent) put_bends(block, at, gain * by.by_place_x, gain * by.by_place_y);
}

template <int kFelt, bool kStretched>
inline void evaluate_all(const TagTable& table, TagBlock& block) {
  for (int at = 0; at < block.size; at += kFloatLanes) {
    const PixelPack pixel = {load<Pack>(&block.x[at]), load<Pack>(&block.y[at]),
                             load<Pack>(&block.xx[at]), load<Pack>(&block.xy[at]),
                             load<Pack>(&block.yy[at])};
    FeltLine columns[kFelt], rows[kFelt];
    for (int i = 0; i < kFelt; ++i) {
      feel<kStretched>(table, table.columns.lines + i, block.column + at, pixel, columns[i]);
      feel<kStretched>(table, table.rows.lines + i, block.row + at, pixel, rows[i]);
    }
    Pack white = blend<kFelt>(block, at, columns, rows);
    ByGeometry by;
    const Pack per_tag = 1.0F + table.last_x * pixel.x + table.last_y * pixel.y;
    shift_borders<kFelt>(table, per_tag, columns, by.shifts);
    shift_borders<kFelt>(table, per_tag, rows, by.shifts);
    for (int j = 0; j < kFelt; ++j) {
      const BitPack upper = load<BitPack>(&block.cells[j][at]);
      const BitPack lower = load<BitPack>(&block.cells[j + 1][at]);
      for (int i = 0; i < kFelt; ++i) {
        const Pack a = cell(upper, i), b = cell(upper, i + 1), c = cell(lower, i),
                   d = cell(lower, i + 1), contrast = d - c - b + a;
        const Pack rho = cosine<kStretched>(pixel, columns[i], rows[j]);
        white += junction(table.num_terms, contrast, rho, columns[i], rows[j]);
        if (table.is_far_shifted)
          shift_corner(contrast, a + b + c + d, columns[i], rows[j], by.shifts);
      }
    }
    white += by.shifts.white;
    by.by_log_spread += by.shifts.by_log_spread;
    for (int i = 0; i < kFelt; ++i) {
      differentiate(table, pixel, columns[i], by.columns, by);
      differentiate(table, pixel, rows[i], by.rows, by);
    }
    put_derivatives(table, block, at, white, by);
  }
}

template <bool kStretched>
inline void evaluate_with(const TagTable& table, TagBlock& block) {
  if (block.num_felt == 1) return evaluate_all<1, kStretched>(table, block);
  if (block.num_felt == 2) return evaluate_all<2, kStretched>(table, block);
  if (block.num_felt == 3) return evaluate_all<3, kStretched>(table, block);
  if (block.num_felt == 4) return evaluate_all<4, kStretched>(table, block);
  if (block.num_felt == 6) return evaluate_all<6, kStretched>(table, block);
  evaluate_all<kMaxTagLines, kStretched>(table, block);
}

inline int num_columns(const TagBlock& block) {
  return block.is_bent ? kTagColumns : kTagStraightColumns;
}

// Fills the last pack with copies of the first pixel and sets their derivatives to zero.
void evaluate(const TagTable& table, TagBlock& block) {
  const int padded = (block.size + kTagPack - 1) / kTagPack * kTagPack;
  float* const all_values[] = {block.x,     block.y,  block.raw_x, block.raw_y,
                               block.level, block.xx, block.xy,    block.yy};
  for (int i = block.size; i < padded; ++i) {
    for (float* values : all_values) values[i] = values[0];
    block.column[i] = block.column[0];
    block.row[i] = block.row[0];
    for (int j = 0; j <= block.num_felt; ++j) block.cells[j][i] = block.cells[j][0];
  }
  if (block.is_stretched)
    evaluate_with<true>(table, block);
  else
    evaluate_with<false>(table, block);
  const int columns = num_columns(block);
  for (int k = 0; k < columns; ++k)
    for (int i = block.size; i < padded; ++i) block.derivatives[k][i] = 0;
}

void locate(const TagLocateJob& job) {
  const TagLine* const lines = job.axis->lines;
  const int last_line = job.axis->count - 1;
  for (int c = job.from; c < job.to; c += kFloatLanes) {
    const Pack x = load<Pack>(job.x + c), y = load<Pack>(job.y + c);
    const auto distance = [&](int i) {
      return lines[i].by_x * x + lines[i].by_y * y + lines[i].by_1;
    };
    IntPack first = 1 - IntPack{}, last = first;
    for (int i = 1; i < last_line; ++i) {
      const Pack d = distance(i);
      first -= d >= job.reach;
      last -= d > -job.reach;
    }
    const IntPack is_known = (distance(0) >= job.unknown) & (distance(last_line) <= -job.unknown);
    store(job.first + c, first);
    store(job.last + c, last);
    store(job.is_known + c, is_known & load<IntPack>(job.is_known + c));
  }
}

// Products of two columns with four, in single precision over a block.
inline void add_tile(const TagBlock& block, int row, int column, double* sums) {
  Pack products[2][4] = {};
  for (int at = 0; at < block.size; at += kFloatLanes) {
    const Pack a = load<Pack>(&block.derivatives[row][at]);
    const Pack b = load<Pack>(&block.derivatives[row + 1][at]);
    for (int j = 0; j < 4; ++j) {
      const Pack c = load<Pack>(&block.derivatives[column + j][at]);
      products[0][j] += a * c;
      products[1][j] += b * c;
    }
  }
  for (int i = 0; i < 2; ++i) add_sums(products[i], sums + (row + i) * kTagColumns + column);
}

void add_products(const TagBlock& block, double* sums) {
  for (int i = 0; i < num_columns(block); i += 2)
    for (int j = 0; j <= i + 1; j += 4) add_tile(block, i, j, sums);
}

}  // namespace
}  // namespace tagcal::internal
