#pragma once

#include <cstdint>

// Private to detect: the loops over pixels of refine_tag(), for the processor at hand. Files of
// kernels are compiled for one kind of processor and include only this header, internal/pack.hpp,
// refine_tag_packs.hpp, refine_tag_felt_lines.hpp, refine_tag_border_shifts.hpp and
// refine_tag_kernel_loops.hpp: the linker could take an inline function of another header from
// there for programs on other processors.
namespace tagcal::internal {

constexpr int kTagPack = 8;       // largest number of pixels in a vector
constexpr int kTagBlock = 128;    // pixels that are evaluated at once
constexpr int kMaxTagLines = 24;  // of one direction
// Spreads within which a line is felt: beyond, 1e-4 of its step is left.
constexpr float kTagReach = 3.8F;  // numeric: truncation of the normal integral

// A line between cells: its distance from a place (x, y), in spreads, and its origin.
struct alignas(32) TagLine {
  float by_x, by_y, by_1;  // distance = by_x x + by_y y + by_1, growing with places on the tag
  float at;                // u or v on the tag
  float inv_length;        // 1 / length of the normal part of (m1 or m2) - at m3
  float unused[3];         // pads to eight numbers, which a pack of lines transposes
};

// The lines of one direction, ascending; the rest of the array are lines that are never reached.
struct TagAxis {
  TagLine lines[2 * kMaxTagLines];
  int count;
};

// The model's parameters for all pixels.
struct TagTable {
  TagAxis columns, rows;
  float per_unit;  // spreads per unit of the places
  float per_px;    // spreads per pixel
  float box;       // fourth cumulant of a pixel's square over 24 spread^4, along a side
  int num_terms;   // of the series for the integral over a quadrant
  float black, gain, gain_by_x, gain_by_y;
  // Shifts of the borders between black and white towards black, in spreads: constant in the
  // picture (bloom), and constant on the tag (ink; where one unit of the tag is one of the places).
  float shift, shift_on_tag;
  bool is_far_shifted;   // the shifts need more than the first order
  float last_x, last_y;  // the homography's last row without its 1
  // Grey = light^gamma; light and grey of black, in units of those of white.
  float gamma, black_light, black_grey;
};

// Finds the lines that are felt along a row of pixels.
struct TagLocateJob {
  const TagAxis* axis;
  const float *x, *y;  // places
  int from, to;        // up to kTagPack - 1 more are read and written
  float reach;         // spreads within which a line is felt
  float unknown;       // spreads within which the unknown beyond the outermost lines is felt
  // Results: lines [first, last) are felt; is_known has all bits set if the outermost lines are
  // farther than `unknown`, else none (it is combined with its old value by and).
  std::int32_t *first, *last, *is_known;
};

// Columns of derivatives: by the homography, by the spread's logarithm, by the grey levels (black,
// gain, its slopes), then the residual, then by the two shifts, then by the bends.
constexpr int kTagResidual = 13;
constexpr int kTagStraightColumns = 16;
constexpr int kTagColumns = 28;  // with the bends

// Pixels whose derivatives by the geometry are not zero.
struct alignas(64) TagBlock {
  float x[kTagBlock], y[kTagBlock];          // places, bent
  float raw_x[kTagBlock], raw_y[kTagBlock];  // places before they are bent
  float level[kTagBlock];
  // Stretch of the places against pixels by a known lens, as in RowPlaces.
  float xx[kTagBlock], xy[kTagBlock], yy[kTagBlock];
  std::int32_t column[kTagBlock], row[kTagBlock];  // first lines that are felt
  // Bit i: cell i is white, counted from the cell before the first felt column line, in each row of
  // cells from the one before the first felt row line on.
  std::uint32_t cells[kMaxTagLines + 1][kTagBlock];
  float derivatives[kTagColumns][kTagBlock];  // results
  int size;
  int num_felt;  // largest number of lines of one direction at a pixel: 1 to 4, 6 or all
  bool is_stretched;
  bool is_bent;
};

struct TagKernels {
  void (*locate)(const TagLocateJob& job);
  // Computes share of white and derivatives; zeros up to a whole pack of pixels.
  void (*evaluate)(const TagTable& table, TagBlock& block);
  // Adds the products of the block's columns to the lower triangle of kTagColumns^2 sums.
  void (*add_products)(const TagBlock& block, double* sums);
};

extern const TagKernels kPortableTagKernels;
extern const TagKernels kAvx2TagKernels;  // null if the compiler has no AVX2
const TagKernels& fastest_tag_kernels();

}  // namespace tagcal::internal
