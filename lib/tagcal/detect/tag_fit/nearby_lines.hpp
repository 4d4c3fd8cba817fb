#pragma once

#include "tagcal/detect/tag_fit/tag_kernels.hpp"
#include "tagcal/detect/tag_fit/tag_packs.hpp"

// Share of white at a pack of pixels from the lines near them. A line is felt at a pixel within
// kTagReach spreads of it. Included by the files of kernels only.
namespace tagcal::internal {
namespace {

// A line at a pack of pixels.
struct FeltLine {
  LinePack line;
  Pack normal_x, normal_y, stretched;
  Pack distance;        // spreads
  Pack density;         // of the normal distribution at the distance
  Pack step, slope;     // normal integral with the pixel's square, and its derivative
  Pack by_distance;     // derivative of white by the distance
  Pack border, change;  // share of the line that is a border: to white plus and minus to black
  Pack near;            // the distance, clamped for polynomials in it
  Pack there;           // spreads by which a shift of one on the tag moves the line
  Pack white, white_by_shift;  // change of white by the shift of a border, and its derivative
  Pack box;                    // fourth cumulant of the pixel's square along the normal
};

// Normal integral (Abramowitz & Stegun 7.1.26) and density, each with an error below 3e-6.
inline void set_profile(FeltLine& felt) {
  const Pack z = felt.distance, size = magnitude(z);
  const Pack twelve = splat<Pack>(12.0F);
  const Pack a = size < twelve ? size : twelve;
  felt.near = z < 0.0F ? -a : a;
  const Pack e = exp_minus(0.5F * a * a);           // numeric: exp(-a^2 / 2)
  const Pack t = 1.0F / (1.0F + 0.231641888F * a);  // numeric: p / sqrt(2) of 7.1.26
  const Pack tail =
      // numeric: half of erfc, by the coefficients of 7.1.26
      0.5F * e * t *
      // numeric: as above
      (0.254829592F +
       // numeric: as above
       t * (-0.284496736F + t * (1.421413741F + t * (-1.453152027F + t * 1.061405429F))));
  const Pack normal = z < 0.0F ? tail : 1.0F - tail;
  const Pack z2 = z * z;
  felt.density = 0.398942280F * e;  // numeric: 1 / sqrt(2 pi)
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
  felt.stretched = splat<Pack>(1.0F);
  if constexpr (kStretched) {
    felt.stretched =
        1.0F / square_root(x2 * pixel.xx + 2.0F * felt.normal_x * felt.normal_y * pixel.xy +
                           y2 * pixel.yy);
    felt.distance *= felt.stretched;
  }
  felt.box = table.box * (x2 * x2 + y2 * y2);
  set_profile(felt);
}

inline Pack cell(BitPack bits, int i) {
  return __builtin_bit_cast(Pack, -(bits >> i & 1U) & 0x3f800000U);
}

// For the felt rows of cells, from the one before the first felt row line on, bit i: cell i is
// white, counted from the cell before the first felt column line.
template <int kFelt>
inline void load_cells(const TagTable& table, const TagBlock& block, int at, BitPack* cells) {
  const IntPack column = load<IntPack>(&block.column[at]) - 1;
  const IntPack row = load<IntPack>(&block.row[at]) - 1;
  for (int j = 0; j <= kFelt; ++j)
    cells[j] = gather(table.cells, row + j) >> __builtin_bit_cast(BitPack, column);
}

// Share of white by the products of steps, as if rows and columns were at right angles, and its
// derivatives.
template <int kFelt>
inline Pack blend(const BitPack* cells, FeltLine* columns, FeltLine* rows) {
  Pack white = {}, last = {};
  Pack widths[kFelt + 1];
  for (int i = 0; i <= kFelt; ++i) {
    const Pack before = i == 0 ? splat<Pack>(1.0F) : columns[i - 1].step;
    widths[i] = i == kFelt ? before : before - columns[i].step;
  }
  for (int i = 0; i < kFelt; ++i) columns[i].by_distance = columns[i].border = Pack{};
  BitPack above = {};
  for (int j = 0; j <= kFelt; ++j) {
    const BitPack bits = cells[j], changes = bits ^ (bits >> 1);
    const Pack before = j == 0 ? splat<Pack>(1.0F) : rows[j - 1].step;
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

// The correlation's part of the bivariate normal integral over a quadrant at (h, k): the sum over
// n >= 0 of rho^(n+1) / (n+1)! He_n(h) He_n(k) times both densities (Pearson 1901).
inline Pack junction(int num_terms, Pack contrast, Pack rho, FeltLine& column, FeltLine& row) {
  const Pack h = column.near, k = row.near;
  Pack of_h = splat<Pack>(1.0F), next_of_h = h, of_k = of_h, next_of_k = k;
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

}  // namespace
}  // namespace tagcal::internal
