#pragma once

#include <cstdint>

// Private to detect: the loops over pixels of refine_tag(), for the processor at hand. Files of
// kernels are compiled for one kind of processor and include this header, refine_tag_packs.hpp and
// refine_tag_kernel_loops.hpp only: a function of another header might be taken from there by
// programs that run elsewhere.
namespace tagcal::internal {

constexpr int kTagPack = 8;        // pixels that kernels take at once
constexpr int kTagBlock = 128;     // pixels whose derivatives stand side by side
constexpr int kMaxTagLines = 24;   // of one direction
constexpr float kTagReach = 3.8F;  // spreads at which a line is felt: 1e-4 of its step

// A border between cells: its distance from a place (x, y), in spreads, and where it comes from.
struct alignas(32) TagLine {
  float by_x, by_y, by_1;  // distance = by_x x + by_y y + by_1, growing with places on the tag
  float at;                // place on the tag
  float inv_length;        // of the normal part of (m1 or m2) - at m3
  float unused[3];         // so that a pack of lines can be turned
};

// The lines of one direction, ascending; after them as many that are never reached.
struct TagAxis {
  TagLine lines[2 * kMaxTagLines];
  int count;
};

// What a model says of any pixel.
struct TagTable {
  TagAxis columns, rows;
  float per_unit;  // spreads in a unit of the places
  float per_px;    // and in a pixel
  float box;       // fourth cumulant of a pixel's square over 24 spread^4, along a side
  int num_terms;   // of the series for the integral over a quadrant
  float black, gain, gain_by_x, gain_by_y;
  // How far borders between black and white are shifted towards black: as far everywhere in the
  // picture, and as far everywhere on the tag; spreads, the latter where one unit of the tag is one
  // of the places.
  float shift, shift_on_tag;
  bool is_far_shifted;   // so that more than the first order counts
  float last_x, last_y;  // the homography's last row, but for its 1
  // Grey is light to the power of gamma; light and grey of black, where those of white are 1.
  float gamma, black_light, black_grey;
};

// Which lines are felt along a row of pixels.
struct TagLocateJob {
  const TagAxis* axis;
  const float *x, *y;  // places
  int from, to;        // up to kTagPack - 1 more are read and written
  float reach;         // spreads at which a line is felt
  float unknown;       // likewise beyond the outermost lines
  // Results: lines [first, last) are felt; whether the outermost lines are farther than `unknown`,
  // all bits or none (joined with what is there).
  std::int32_t *first, *last, *is_known;
};

// Columns of derivatives: of the homography, of the spread's logarithm, of the grey levels (black,
// gain, its slopes), then the residual, then of the two shifts, then the bends.
constexpr int kTagResidual = 13;
constexpr int kTagStraightColumns = 16;
constexpr int kTagColumns = 28;  // with the bends

// Pixels that know of the geometry.
struct alignas(64) TagBlock {
  float x[kTagBlock], y[kTagBlock];          // places, bent
  float raw_x[kTagBlock], raw_y[kTagBlock];  // and as they are in the picture
  float level[kTagBlock];
  // Where a known lens stretches places against pixels: squares and product of the slopes of the
  // places over the picture.
  float xx[kTagBlock], xy[kTagBlock], yy[kTagBlock];
  std::int32_t column[kTagBlock], row[kTagBlock];  // first lines that are felt
  // Bit i: cell i from the one before the first column line on is white, in each row of cells from
  // the one before the first row line on.
  std::uint32_t cells[kMaxTagLines + 1][kTagBlock];
  float derivatives[kTagColumns][kTagBlock];  // results
  int size;
  int num_felt;  // lines of either direction, at most, at any pixel; of kernels 1 to 4, 6 or all
  bool is_stretched;
  bool is_bent;
};

struct TagKernels {
  void (*locate)(const TagLocateJob& job);
  // Share of white and derivatives; zeros up to a whole pack of pixels.
  void (*evaluate)(const TagTable& table, TagBlock& block);
  // Adds the products of the block's columns: the lower triangle of kTagColumns^2 sums.
  void (*add_products)(const TagBlock& block, double* sums);
};

extern const TagKernels kPortableTagKernels;
extern const TagKernels kAvx2TagKernels;  // null where the compiler has none
const TagKernels& fastest_tag_kernels();

}  // namespace tagcal::internal
