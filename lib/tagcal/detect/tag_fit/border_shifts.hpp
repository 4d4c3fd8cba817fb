#pragma once

#include "tagcal/detect/tag_fit/nearby_lines.hpp"

// Shifts of the borders between black and white, by ink and bloom, in the share of white. Included
// by the files of kernels only.
namespace tagcal::internal {
namespace {

// Change of white by the shifts, and its derivatives.
struct ByShift {
  Pack by_shift = {}, by_shift_on_tag = {}, by_log_spread = {}, white = {};

  void add(Pack by_this, Pack there, Pack shift) {
    by_shift += by_this;
    by_shift_on_tag += by_this * there;
    by_log_spread -= by_this * shift;
  }
};

// The same line at another distance.
inline FeltLine moved(FeltLine line, Pack shift) {
  line.distance += shift;
  set_profile(line);
  return line;
}

// A shift moves borders to white one way and borders to black the other: a line at distance z with
// a share a of the first and b of the second contributes a step(z + s) - b step(z - s).
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
      const Pack sum = line.border + line.change;
      const Pack a = 0.5F * sum, b = line.border - a;  // numeric: half
      by.white += a * (to_white.step - line.step) - b * (to_black.step - line.step);
      by_shift = a * to_white.slope + b * to_black.slope;
      line.by_distance += a * (to_white.slope - line.slope) - b * (to_black.slope - line.slope);
      line.white = 0.5F * (to_white.step - to_black.step);             // numeric: half
      line.white_by_shift = 0.5F * (to_white.slope + to_black.slope);  // numeric: half
    }
    by.add(by_shift, line.there, shift);
  }
}

// Adds the joint effect of the shifts of two crossing lines: a white corner grows by the square of
// the shift, a black one shrinks, two that touch join. `num_white`: of the four cells.
inline void shift_corner(Pack contrast, Pack num_white, const FeltLine& column, const FeltLine& row,
                         ByShift& by) {
  const Pack size = magnitude(contrast), single = size * (2.0F - num_white);
  const Pack touching = size > 1.5F ? splat<Pack>(2.0F) : Pack{};  // numeric: between 1 and 2
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

}  // namespace
}  // namespace tagcal::internal
