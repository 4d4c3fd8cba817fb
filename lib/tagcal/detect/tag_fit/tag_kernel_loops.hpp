#pragma once

#include "tagcal/detect/tag_fit/border_shifts.hpp"
#include "tagcal/detect/tag_fit/nearby_lines.hpp"
#include "tagcal/detect/tag_fit/tag_kernels.hpp"
#include "tagcal/detect/tag_fit/tag_packs.hpp"

// The loops of tag_kernels.hpp. Included by the files of kernels only.
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

inline void put(TagDerivatives& derivatives, int column, int at, Pack values) {
  store(&derivatives.columns[column][at], values);
}

inline void put_bends(TagDerivatives& all, int at, Pack x, Pack y, Pack by_x, Pack by_y) {
  const Pack xx = x * x, xy = x * y, yy = y * y;
  int column = kTagResidual + 3;
  put(all, column++, at, by_x * yy);
  put(all, column++, at, by_y * xx);
  put(all, column++, at, by_x * xx - by_y * xy);
  put(all, column++, at, by_x * xy - by_y * yy);
  const Pack both[2] = {by_x, by_y};
  for (const Pack by : both) {
    put(all, column++, at, by * x * xx);
    put(all, column++, at, by * x * xy);
    put(all, column++, at, by * x * yy);
    put(all, column++, at, by * y * yy);
  }
}

inline void put_derivatives(const TagTable& table, const TagBlock& block, int at, Pack white,
                            const ByGeometry& by, TagDerivatives& all) {
  const Pack x = load<Pack>(&block.x[at]), y = load<Pack>(&block.y[at]);
  const Pack contrast = table.gain + table.gain_by_x * x + table.gain_by_y * y;
  Pack gain = contrast;
  if (table.gamma != 1.0F) white = grey_of_light(table, white, gain);
  const Pack model = table.black + contrast * white;
  Pack level = load<Pack>(&block.level[at]);
  const Pack zero = {}, one = is_clipped(table, level, model) ? zero : splat<Pack>(1.0F);
  gain *= one;
  white *= one;
  int column = 0;
  const ByHomography* const parts[2] = {&by.columns, &by.rows};
  for (const ByHomography* part : parts) {
    put(all, column++, at, gain * part->by_x);
    put(all, column++, at, gain * part->by_y);
    put(all, column++, at, gain * part->by_1);
  }
  put(all, column++, at, gain * by.by_last_x);
  put(all, column++, at, gain * by.by_last_y);
  put(all, column++, at, gain * by.by_log_spread);
  put(all, column++, at, one);
  put(all, column++, at, white);
  put(all, column++, at, white * x);
  put(all, column++, at, white * y);
  put(all, column++, at, one * (level - table.black - contrast * white));
  put(all, column++, at, gain * table.per_px * by.shifts.by_shift);
  put(all, column, at, gain * table.per_px * by.shifts.by_shift_on_tag);
  if (block.is_bent) put_bends(all, at, x, y, gain * by.by_place_x, gain * by.by_place_y);
}

// Moves places by the bends, as bend_basis() has them.
inline void bend(const float* b, Pack& x, Pack& y) {
  const Pack xx = x * x, xy = x * y, yy = y * y;
  const Pack by_x =
      yy * b[0] + xx * b[2] + xy * b[3] + x * (xx * b[4] + xy * b[5] + yy * b[6]) + y * yy * b[7];
  const Pack by_y =
      xx * b[1] - xy * b[2] - yy * b[3] + x * (xx * b[8] + xy * b[9] + yy * b[10]) + y * yy * b[11];
  x += by_x;
  y += by_y;
}

template <int kFelt, bool kStretched>
inline void evaluate_all(const TagTable& table, const TagBlock& block, TagDerivatives& all) {
  for (int at = 0; at < block.size; at += kFloatLanes) {
    PixelPack pixel = {load<Pack>(&block.x[at]), load<Pack>(&block.y[at]),
                       load<Pack>(&block.xx[at]), load<Pack>(&block.xy[at]),
                       load<Pack>(&block.yy[at])};
    if (table.is_bent) bend(table.bends, pixel.x, pixel.y);
    FeltLine columns[kFelt], rows[kFelt];
    for (int i = 0; i < kFelt; ++i) {
      feel<kStretched>(table, table.columns.lines + i, block.column + at, pixel, columns[i]);
      feel<kStretched>(table, table.rows.lines + i, block.row + at, pixel, rows[i]);
    }
    BitPack cells[kFelt + 1];
    load_cells<kFelt>(table, block, at, cells);
    Pack white = blend<kFelt>(cells, columns, rows);
    ByGeometry by;
    const Pack per_tag = 1.0F + table.last_x * pixel.x + table.last_y * pixel.y;
    shift_borders<kFelt>(table, per_tag, columns, by.shifts);
    shift_borders<kFelt>(table, per_tag, rows, by.shifts);
    for (int j = 0; j < kFelt; ++j) {
      const BitPack upper = cells[j], lower = cells[j + 1];
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
    put_derivatives(table, block, at, white, by, all);
  }
}

template <bool kStretched>
inline void evaluate_with(const TagTable& table, const TagBlock& block, TagDerivatives& all) {
  if (block.num_felt == 1) return evaluate_all<1, kStretched>(table, block, all);
  if (block.num_felt == 2) return evaluate_all<2, kStretched>(table, block, all);
  if (block.num_felt == 3) return evaluate_all<3, kStretched>(table, block, all);
  if (block.num_felt == 4) return evaluate_all<4, kStretched>(table, block, all);
  if (block.num_felt == 6) return evaluate_all<6, kStretched>(table, block, all);
  if (block.num_felt == 8) return evaluate_all<8, kStretched>(table, block, all);
  if (block.num_felt == 12) return evaluate_all<12, kStretched>(table, block, all);
  if (block.num_felt == 16) return evaluate_all<16, kStretched>(table, block, all);
  evaluate_all<kMaxTagLines, kStretched>(table, block, all);
}

inline int num_columns(const TagDerivatives& derivatives) {
  return derivatives.is_bent ? kTagColumns : kTagStraightColumns;
}

// Fills the last pack with copies of the first pixel and sets their derivatives to zero.
void evaluate(const TagTable& table, TagBlock& block, TagDerivatives& all) {
  const int padded = (block.size + kTagPack - 1) / kTagPack * kTagPack;
  float* const inputs[] = {block.x, block.y, block.level, block.xx, block.xy, block.yy};
  for (int i = block.size; i < padded; ++i) {
    for (float* values : inputs) values[i] = values[0];
    block.column[i] = block.column[0];
    block.row[i] = block.row[0];
  }
  if (block.is_stretched)
    evaluate_with<true>(table, block, all);
  else
    evaluate_with<false>(table, block, all);
  all.size = block.size;
  all.is_bent = block.is_bent;
  for (int k = 0; k < num_columns(all); ++k)
    for (int i = block.size; i < padded; ++i) all.columns[k][i] = 0;
}

inline Pack distance(const TagLine& line, Pack x, Pack y) {
  return line.by_x * x + line.by_y * y + line.by_1;
}

// All bits set where the outermost lines are farther than `reach`, else none.
inline IntPack is_within(const TagAxis& axis, Pack x, Pack y, float reach) {
  return (distance(axis.lines[0], x, y) >= reach) &
         (distance(axis.lines[axis.count - 1], x, y) <= -reach);
}

// The lines of a direction that are felt: the first of the inner ones, and their number. (Lines
// that cross, after a poor start, are not reached in their order.)
struct FeltRange {
  IntPack first = 1 - IntPack{}, last = first;

  void add(Pack distance, float reach) {
    first -= distance >= reach;
    last -= distance > -reach;
  }
  IntPack count() const { return last > first ? last - first : IntPack{}; }
};

inline FeltRange felt_columns(const TagAxis& axis, Pack x, Pack y, float reach) {
  FeltRange range;
  for (int i = 1; i < axis.count - 1; ++i) range.add(distance(axis.lines[i], x, y), reach);
  return range;
}

// What is known of pixels (kSeen..) by the cells about the lines that are felt.
inline IntPack seen(const TagTable& table, Pack x, Pack y, float reach, const FeltRange& columns,
                    FeltRange& rows) {
  const BitPack shift = __builtin_bit_cast(BitPack, columns.first - 1);
  const BitPack all = (splat<BitPack>(2U) << __builtin_bit_cast(BitPack, columns.count())) - 1U;
  BitPack any_white = {}, all_white = all, unknown = {};
  IntPack is_below = IntPack{} == 0;  // the line above the row of cells
  for (int j = 0; j < table.rows.count - 1; ++j) {
    const Pack d = distance(table.rows.lines[j + 1], x, y);
    const bool is_last = j + 2 == table.rows.count;
    const IntPack is_reached = is_below & (is_last ? IntPack{} == 0 : d < reach);
    if (!is_last) rows.add(d, reach);
    is_below = d > -reach;
    if (!any_set(is_reached)) continue;
    const BitPack is_there = __builtin_bit_cast(BitPack, is_reached);
    const BitPack white = splat<BitPack>(table.cells[j]) >> shift;
    any_white |= white & is_there;
    all_white &= white | ~is_there;
    unknown |= splat<BitPack>(table.unknown[j]) >> shift & is_there;
  }
  const IntPack lines =
      ((columns.count() > 1) | (rows.count() > 1)) ? kSeenLines - IntPack{} : kSeenLine - IntPack{};
  const IntPack cells = (any_white & all) == 0U ? kSeenBlack - IntPack{} : lines;
  return (unknown & all) != 0U ? IntPack{} : all_white == all ? kSeenWhite - IntPack{} : cells;
}

// Adds the pixels that a mask selects.
template <bool kLight>
inline void add_flat(IntPack mask, Pack x, Pack y, Pack r, Pack* sums) {
  const Pack zero = {};
  x = mask ? x : zero;
  y = mask ? y : zero;
  r = mask ? r : zero;
  const Pack xx = x * x, xy = x * y, yy = y * y;
  const Pack terms[] = {mask ? splat<Pack>(1.0F) : zero,
                        x,
                        y,
                        xx,
                        xy,
                        yy,
                        r,
                        x * r,
                        y * r,
                        xx * r,
                        xy * r,
                        yy * r,
                        r * r};
  for (const Pack& term : terms) *sums++ += term;
  if (!kLight) return;
  const Pack of_light[] = {x * xx,  xx * y,  x * yy,  y * yy, xx * xx,
                           xx * xy, xx * yy, xy * yy, yy * yy};
  for (const Pack& term : of_light) *sums++ += term;
}

template <int kSums>
inline void add_all_sums(const Pack* packs, TagFlatSums& sums) {
  for (int i = 0; i < kSums; i += 4) add_sums(packs + i, &sums.n + i);
}

inline IntPack lanes() {
  IntPack lane;
  for (int i = 0; i < kFloatLanes; ++i) lane[i] = i;
  return lane;
}

void add_ends(const TagTable& table, const TagBlock& block, bool white, TagFlatSums* flat) {
  constexpr int kSums = 24;  // numbers of TagFlatSums, with those of light
  Pack sums[kSums] = {};
  const float share = white ? 1.0F : 0.0F;
  for (int at = 0; at < block.size; at += kFloatLanes) {
    const Pack x = load<Pack>(&block.x[at]), y = load<Pack>(&block.y[at]);
    const Pack contrast = table.gain + table.gain_by_x * x + table.gain_by_y * y;
    const Pack model = table.black + share * contrast;
    Pack level = load<Pack>(&block.level[at]);
    const IntPack is_seen = ~is_clipped(table, level, model) & (lanes() < block.size - at);
    if (any_set(is_seen)) add_flat<true>(is_seen, x, y, level - model, sums);
  }
  add_all_sums<kSums>(sums, *flat);
}

template <bool kLight>
inline void select_with(const TagTable& table, const TagPixelRow& row, TagFlatSums* flat) {
  constexpr int kSums = kLight ? 24 : 16;
  Pack sums[2][kSums] = {};  // as in TagFlatSums
  for (int c = row.from; c < row.to; c += kFloatLanes) {
    const Pack raw_x = load<Pack>(row.x + c), raw_y = load<Pack>(row.y + c);
    Pack x = raw_x, y = raw_y;
    if (table.is_bent) bend(table.bends, x, y);
    const IntPack is_known = (lanes() < row.to - c) & is_within(table.columns, x, y, row.unknown) &
                             is_within(table.rows, x, y, row.unknown);
    store(row.seen + c, IntPack{});
    if (!any_set(is_known)) continue;
    const FeltRange columns = felt_columns(table.columns, x, y, row.reach);
    FeltRange rows;
    const Pack level = load<Pack>(row.level + c);
    IntPack kind = is_known & seen(table, x, y, row.reach, columns, rows);
    const IntPack is_at_end = (level >= table.full_level) | (level <= table.least_level);
    const IntPack is_flat = (kind == kSeenBlack) | (kind == kSeenWhite);
    kind += is_flat & is_at_end & (kSeenBlackEnd - kSeenBlack);
    store(row.column + c, columns.first);
    store(row.row + c, rows.first);
    const IntPack of_columns = columns.count(), of_rows = rows.count();
    store(row.num_felt + c, of_columns > of_rows ? of_columns : of_rows);
    store(row.seen + c, kind);
    const IntPack is_black = kind == kSeenBlack, is_white = kind == kSeenWhite;
    if (any_set(is_black)) add_flat<kLight>(is_black, raw_x, raw_y, level - table.black, sums[0]);
    if (!any_set(is_white)) continue;
    const Pack contrast = table.gain + table.gain_by_x * raw_x + table.gain_by_y * raw_y;
    add_flat<kLight>(is_white, raw_x, raw_y, level - table.black - contrast, sums[1]);
  }
  for (int colour = 0; colour < 2; ++colour) add_all_sums<kSums>(sums[colour], flat[colour]);
}

void select(const TagTable& table, const TagPixelRow& row, TagFlatSums* flat) {
  if (row.has_light)
    select_with<true>(table, row, flat);
  else
    select_with<false>(table, row, flat);
}

// Products of two columns with four, in single precision over a block.
inline void add_tile(const TagDerivatives& all, int row, int column, double* sums, int stride) {
  Pack products[2][4] = {};
  for (int at = 0; at < all.size; at += kFloatLanes) {
    const Pack a = load<Pack>(&all.columns[row][at]);
    const Pack b = load<Pack>(&all.columns[row + 1][at]);
    for (int j = 0; j < 4; ++j) {
      const Pack c = load<Pack>(&all.columns[column + j][at]);
      products[0][j] += a * c;
      products[1][j] += b * c;
    }
  }
  for (int i = 0; i < 2; ++i) add_sums(products[i], sums + i * stride);
}

void add_products(const TagDerivatives& all, double* sums) {
  for (int i = 0; i < num_columns(all); i += 2)
    for (int j = 0; j <= i + 1; j += 4)
      add_tile(all, i, j, sums + i * kTagColumns + j, kTagColumns);
}

void add_light_products(const TagDerivatives& all, double* sums) {
  constexpr int kAll = kTagColumns + kTagLightColumns;
  for (int i = 0; i < kTagLightColumns; i += 2) {
    for (int j = 0; j < num_columns(all); j += 4)
      add_tile(all, kTagColumns + i, j, sums + i * kAll + j, kAll);
    for (int j = 0; j <= i + 1; j += 4)
      add_tile(all, kTagColumns + i, kTagColumns + j, sums + i * kAll + kTagColumns + j, kAll);
  }
}

}  // namespace
}  // namespace tagcal::internal
