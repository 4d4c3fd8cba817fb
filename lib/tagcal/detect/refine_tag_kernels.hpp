#pragma once

// Private to detect: the loops over pixels of refine_tag(), for the processor at hand. Files of
// kernels are compiled for one kind of processor and include this header and
// refine_tag_kernel_loops.hpp only: a function of another header might be taken from there by
// programs that run elsewhere.
namespace tagcal {

// The step of one line along a row of pixels [from, to), by their number.
struct TagProfileJob {
  const float* x = nullptr;  // places
  const float* y = nullptr;
  // Squares and product of the places' slopes; null where one unit is as long everywhere.
  const float* xx = nullptr;
  const float* xy = nullptr;
  const float* yy = nullptr;
  float normal_x = 0, normal_y = 0;
  float by_x = 0, by_y = 0, by_1 = 0;  // of the distance in spreads
  float box = 0;
  int from = 0, to = 0;
  // Results: distance in spreads, Gaussian density there, the step with the pixel's square and its
  // derivative by that distance; px per stretched px, only where stretched.
  float* distance = nullptr;
  float* density = nullptr;
  float* step = nullptr;
  float* slope = nullptr;
  float* factor = nullptr;
};

constexpr int kTagGramRows = 20;  // and columns, of the result
constexpr int kTagPack = 8;       // sizes are whole multiples of it

struct TagKernels {
  void (*profile)(const TagProfileJob& job) = nullptr;
  // Scalar products of `count` (even) vectors of `size` floats, `stride` apart, of which at least
  // the lower triangle is set. Two vectors more may be read.
  void (*gram)(const float* vectors, int stride, int count, int size, float* products) = nullptr;
};

extern const TagKernels kPortableTagKernels;
extern const TagKernels kAvx2TagKernels;  // null where the compiler has none
const TagKernels& fastest_tag_kernels();

}  // namespace tagcal
