#pragma once

#include <cstdint>

// Private to detect: the loops over pixels of refine_tag(), for the processor at hand. Files of
// kernels are compiled for one kind of processor and include only this header, internal/pack.hpp,
// tag_packs.hpp, nearby_lines.hpp, border_shifts.hpp and tag_kernel_loops.hpp: the linker could
// take an inline function of another header from there for programs on other processors.
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
  // The ends of the levels' range. A level at one of them, or beyond, is a bound: moved back
  // towards the range by `beyond`, it is the least, or the most, that the light is.
  float least_level, full_level, beyond;
  // Shifts of the borders between black and white towards black, in spreads: constant in the
  // picture (bloom), and constant on the tag (ink; where one unit of the tag is one of the places).
  float shift, shift_on_tag;
  bool is_far_shifted;   // the shifts need more than the first order
  float last_x, last_y;  // the homography's last row without its 1
  // Grey = light^gamma; light and grey of black, in units of those of white.
  float gamma, black_light, black_grey;
  float bends[12];  // numeric: of places, as bend_basis() has them
  bool is_bent;     // some of them are not zero
  // For each row of cells, bit i: cell i is white, or unknown. Rows of zeros follow.
  std::uint32_t cells[2 * kMaxTagLines], unknown[2 * kMaxTagLines];
};

// What is known of a pixel: nothing, or that the cells that influence it are all black, all white,
// or both, which is felt across one line of each direction or across several. At an end of the
// levels' range the model decides whether a pixel of one colour is clipped.
constexpr std::int32_t kSeenNothing = 0, kSeenBlack = 1, kSeenWhite = 2, kSeenBlackEnd = 3,
                       kSeenWhiteEnd = 4, kSeenLine = 5, kSeenLines = 6;

// A row of pixels. Up to kTagPack - 1 more than [from, to) are read and written.
struct TagPixelRow {
  int from, to;
  const float *x, *y;  // places before they are bent
  const float* level;
  const float *xx, *xy, *yy;  // as in RowPlaces
  float reach;                // spreads within which a line is felt
  float unknown;              // spreads within which the unknown beyond the outermost lines is felt
  bool has_light;             // sums of third and fourth order are wanted
  // Results: of the columns and rows of lines the first that is felt; the number of lines that are
  // felt, of the direction that has more; what is known (kSeen..).
  std::int32_t *column, *row, *num_felt, *seen;
};

// Sums over pixels of one colour, whose derivatives by the geometry are zero: of 1, x, y, xx, xy,
// yy, of the residual r times 1, x, y, xx, xy, yy and r, and of terms of third and fourth order.
struct TagFlatSums {
  double n, x, y, xx, xy, yy, r, xr, yr, xxr, xyr, yyr, rr;
  double xxx, xxy, xyy, yyy, xxxx, xxxy, xxyy, xyyy, yyyy, unused[2];
};

// Columns of derivatives: by the homography, by the spread's logarithm, by the grey levels (black,
// gain, its slopes), then the residual, then by the two shifts, then by the bends.
constexpr int kTagResidual = 13;
constexpr int kTagStraightColumns = 16;
constexpr int kTagColumns = 28;  // with the bends
// Further columns, where wanted: terms of light (TagFitter::admit_light), then the residual again;
// an even number.
constexpr int kTagLightColumns = 8;

// Pixels whose derivatives by the geometry are not zero, or of one colour at an end of the range.
struct alignas(64) TagBlock {
  static constexpr int kRoom = kTagBlock + kTagPack;  // pixels are added by whole packs
  float x[kRoom], y[kRoom];                           // places before they are bent
  float level[kRoom];
  float xx[kRoom], xy[kRoom], yy[kRoom];   // as in RowPlaces, if a lens is known
  std::int32_t column[kRoom], row[kRoom];  // first lines that are felt
  int in_patch[kRoom];                     // index of the pixel
  int size = 0;
  int num_felt = 0;  // most lines of one direction at a pixel: 1 to 4, 6, 8, 12, 16 or all
  bool is_stretched = false;
  bool is_bent = false;

  TagBlock() {}  // leaves the pixels open: zeros would cost time
};

// The derivatives of a block's pixels at some parameters.
struct alignas(64) TagDerivatives {
  float columns[kTagColumns + kTagLightColumns][kTagBlock];
  int size;  // of the block
  bool is_bent;
};

struct TagKernels {
  // Finds what is known of the pixels of a row, and adds those of one colour to the sums of black
  // and of white.
  void (*select)(const TagTable& table, const TagPixelRow& row, TagFlatSums* flat);
  // Adds those of a block's pixels, all black or all white, that are not clipped.
  void (*add_ends)(const TagTable& table, const TagBlock& block, bool white, TagFlatSums* flat);
  // Computes share of white and derivatives; zeros up to a whole pack of pixels.
  void (*evaluate)(const TagTable& table, TagBlock& block, TagDerivatives& derivatives);
  // Adds the products of the columns to the lower triangle of kTagColumns^2 sums.
  void (*add_products)(const TagDerivatives& derivatives, double* sums);
  // Adds the products of the columns of light with all columns to kTagLightColumns rows of sums;
  // of the columns of light with each other the lower triangle.
  void (*add_light_products)(const TagDerivatives& derivatives, double* sums);
};

extern const TagKernels kPortableTagKernels;
extern const TagKernels kAvx2TagKernels;  // null if the compiler has no AVX2
const TagKernels& fastest_tag_kernels();

}  // namespace tagcal::internal
