#pragma once

#include "tagcal/detect/tag_fit/refine_tag_kernels.hpp"
#include "tagcal/detect/tag_fit/refine_tag_packs.hpp"

// The loops of refine_tag_kernels.hpp. Included by the files of kernels only.
namespace tagcal::internal {
namespace {

// A line at a pack of pixels: distance in spreads, the Gaussian's density there, the step with the
// pixel's square and its derivative; white by that distance; the share of the line that is a
// border, of either kind, and of borders to white less that of borders to black.
struct FeltLine {
  LinePack line;
  Pack normal_x, normal_y, stretched, distance, density, step, slope, by_distance, border, change;
  Pack near;                   // the distance, but no larger than what polynomials in it can bear
  Pack there;                  // spreads by which a shift of one on the tag moves it
  Pack white, white_by_shift;  // that a border of either kind is worth, by its shift
  Pack box;                    // fourth cumulant of the pixel's square along the normal
};

// Normal integral (Abramowitz & Stegun 7.1.26) and density, each to 3e-6, without branches.
inline void set_profile(FeltLine& felt) {
  const Pack z = felt.distance, size = magnitude(z);
  const Pack twelve = all(12.0F);
  const Pack a = chosen(size < twelve, size, twelve);
  felt.near = chosen(z < 0.0F, -a, a);
  const Pack e = exp_minus(0.5F * a * a);
  const Pack t = 1.0F / (1.0F + 0.231641888F * a);
  const Pack tail =
      0.5F * e * t *
      (0.254829592F +
       t * (-0.284496736F + t * (1.421413741F + t * (-1.453152027F + t * 1.061405429F))));
  const Pack normal = chosen(z < 0.0F, tail, 1.0F - tail);
  const Pack z2 = z * z;
  felt.density = 0.398942280F * e;
  felt.step = normal - felt.box * z * (z2 - 3.0F) * felt.density;
  felt.slope = felt.density * (1.0F + felt.box * (z2 * (z2 - 6.0F) + 3.0F));
}

struct PixelPack {
  Pack x, y, xx, xy, yy;
};

template <bool kStretched>
inline void feel(const TagTable& table, const TagLine* lines, const std::int32_t* first,
                 const PixelPack& pixel, FeltLine& felt) {
  felt.line = load_lines(lines, first);
  const LinePack& line = felt.line;
  felt.normal_x = line.by_x / table.per_unit;
  felt.normal_y = line.by_y / table.per_unit;
  felt.distance = line.by_x * pixel.x + line.by_y * pixel.y + line.by_1;
  const Pack x2 = felt.normal_x * felt.normal_x, y2 = felt.normal_y * felt.normal_y;
  felt.stretched = all(1.0F);
  if constexpr (kStretched) {
    felt.stretched = inverse_root(x2 * pixel.xx + 2.0F * felt.normal_x * felt.normal_y * pixel.xy +
                                  y2 * pixel.yy);
    felt.distance *= felt.stretched;
  }
  felt.box = table.box * (x2 * x2 + y2 * y2);
  set_profile(felt);
}

inline Pack cell(BitPack bits, int i) {
  return __builtin_bit_cast(Pack, -(bits >> i & 1U) & 0x3f800000U);
}

// White by the products of steps, as if rows and columns were at right angles; and by each step.
template <int kFelt>
inline Pack blend(const TagBlock& block, int at, FeltLine* columns, FeltLine* rows) {
  Pack white = {}, last = {};
  Pack widths[kFelt + 1];
  for (int i = 0; i <= kFelt; ++i) {
    const Pack before = i == 0 ? all(1.0F) : columns[i - 1].step;
    widths[i] = i == kFelt ? before : before - columns[i].step;
  }
  for (int i = 0; i < kFelt; ++i) columns[i].by_distance = columns[i].border = Pack{};
  BitPack above = {};
  for (int j = 0; j <= kFelt; ++j) {
    const BitPack bits = load<BitPack>(&block.cells[j][at]), changes = bits ^ (bits >> 1);
    const Pack before = j == 0 ? all(1.0F) : rows[j - 1].step;
    const Pack weight = j == kFelt ? before : before - rows[j].step;
    Pack left = cell(bits, 0), sum = left;
    for (int i = 0; i < kFelt; ++i) {
      const Pack right = cell(bits, i + 1), change = right - left;
      sum += change * columns[i].step;
      columns[i].by_distance += weight * change;
      columns[i].border += weight * cell(changes, i);
      left = right;
    }
    white += weight * sum;
    if (j > 0) {
      rows[j - 1].change = sum - last;
      rows[j - 1].by_distance = rows[j - 1].slope * rows[j - 1].change;
      rows[j - 1].border = Pack{};
      for (int i = 0; i <= kFelt; ++i) rows[j - 1].border += widths[i] * cell(bits ^ above, i);
    }
    last = sum;
    above = bits;
  }
  for (int i = 0; i < kFelt; ++i) {
    columns[i].change = columns[i].by_distance;
    columns[i].by_distance *= columns[i].slope;
  }
  return white;
}

// Cosine of the angle between two lines in the picture.
template <bool kStretched>
inline Pack cosine(const PixelPack& pixel, const FeltLine& a, const FeltLine& b) {
  const Pack xx = a.normal_x * b.normal_x, yy = a.normal_y * b.normal_y;
  if constexpr (!kStretched) return xx + yy;
  const Pack xy = a.normal_x * b.normal_y + a.normal_y * b.normal_x;
  return a.stretched * b.stretched * (xx * pixel.xx + xy * pixel.xy + yy * pixel.yy);
}

// Beyond the product of its steps, the bivariate normal integral over a quadrant at (h, k) is the
// sum over n >= 0 of rho^(n+1) / (n+1)! He_n(h) He_n(k) times both densities (Pearson 1901).
inline Pack junction(int num_terms, Pack contrast, Pack rho, FeltLine& column, FeltLine& row) {
  const Pack h = column.near, k = row.near;
  Pack of_h = all(1.0F), next_of_h = h, of_k = of_h, next_of_k = k;
  Pack term = rho, sum = {}, by_h = {}, by_k = {};
  for (int n = 1; n <= num_terms; ++n) {
    const auto order = static_cast<float>(n);
    const Pack a = term * of_h, b = term * of_k;
    sum += a * of_k;
    by_h += b * next_of_h;
    by_k += a * next_of_k;
    const Pack after_h = h * next_of_h - order * of_h, after_k = k * next_of_k - order * of_k;
    of_h = next_of_h;
    of_k = next_of_k;
    next_of_h = after_h;
    next_of_k = after_k;
    term *= rho * (1.0F / (order + 1.0F));
  }
  const Pack scaled = contrast * column.density * row.density;
  column.by_distance -= scaled * by_h;
  row.by_distance -= scaled * by_k;
  return scaled * sum;
}

// White by the shifts, and what they make of it.
struct ByShift {
  Pack by_shift = {}, by_shift_on_tag = {}, by_log_spread = {}, white = {};

  void add(Pack by_this, Pack there, Pack shift) {
    by_shift += by_this;
    by_shift_on_tag += by_this * there;
    by_log_spread -= by_this * shift;
  }
};

// The same line, moved.
inline FeltLine moved(FeltLine line, Pack shift) {
  line.distance += shift;
  set_profile(line);
  return line;
}

// Borders to white move one way, those to black the other: a line at distance z with a share a of
// the one and b of the other is a step(z + s) - b step(z - s).
template <int kFelt>
inline void shift_borders(const TagTable& table, Pack per_tag, FeltLine* lines, ByShift& by) {
  for (int i = 0; i < kFelt; ++i) {
    FeltLine& line = lines[i];
    line.there = per_tag * line.line.inv_length * line.stretched;
    const Pack shift = table.shift + table.shift_on_tag * line.there;
    Pack by_shift = line.border * line.slope;
    if (!table.is_far_shifted) {
      by.white += shift * by_shift;
      line.by_distance -= shift * line.border * line.near * line.density;
    } else {
      const FeltLine to_white = moved(line, shift), to_black = moved(line, -shift);
      const Pack a = 0.5F * (line.border + line.change), b = line.border - a;
      by.white += a * (to_white.step - line.step) - b * (to_black.step - line.step);
      by_shift = a * to_white.slope + b * to_black.slope;
      line.by_distance += a * (to_white.slope - line.slope) - b * (to_black.slope - line.slope);
      line.white = 0.5F * (to_white.step - to_black.step);
      line.white_by_shift = 0.5F * (to_white.slope + to_black.slope);
    }
    by.add(by_shift, line.there, shift);
  }
}

// Adds what the shifts of two crossing lines do together: a white corner grows by the square of the
// shift, one of black shrinks, two that touch become one. `num_white`: of the four cells.
inline void shift_corner(Pack contrast, Pack num_white, const FeltLine& column, const FeltLine& row,
                         ByShift& by) {
  const Pack size = magnitude(contrast), single = size * (2.0F - num_white);
  const Pack touching = chosen(size > 1.5F, all(2.0F), Pack{});
  const Pack of_row = single * row.white - touching * magnitude(row.white);
  const Pack white = column.white * of_row;
  by.white += white;
  const Pack by_column = column.white_by_shift * of_row;
  const Pack by_row =
      row.white_by_shift * (single * column.white - touching * magnitude(column.white));
  by.by_shift += by_column + by_row;
  by.by_shift_on_tag += by_column * column.there + by_row * row.there;
  by.by_log_spread -= 2.0F * white;
}

// White by a row of the homography's matrix, and by its last row.
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

// The share of white in grey levels from that of light; multiplies `gain` by its derivative.
inline Pack grey_of_light(const TagTable& table, Pack white, Pack& gain) {
  const Pack least = all(1e-3F), light = table.black_light + (1.0F - table.black_light) * white;
  const Pack x = chosen(light > least, light, least);
  const Pack grey = exp_minus(-table.gamma * logarithm(x));
  const Pack stretch = all(1.0F / (1.0F - table.black_grey));
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
  put(block, column++, at, all(1.0F));
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
  for (int at = 0; at < block.size; at += kLanes) {
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

// What stands beyond the last pixel is the first once more: it is of no weight.
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
  for (int c = job.from; c < job.to; c += kLanes) {
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
  for (int at = 0; at < block.size; at += kLanes) {
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
