#pragma once

#include "tagcal/camera/kernels/project_kernels.hpp"

// The kernels of maps and resampling, compiled once for any processor, once for x86-64 with AVX2
// and FMA; reproject_dispatch.cpp chooses at run time. This header has only plain data and
// pointers, no Eigen and no standard library (see internal/pack.hpp).

namespace tagcal::internal {

// The coordinate in a map of a target pixel behind which the source has nothing.
inline constexpr float kNowhere = -1;

// A row of points start + i * step, i = first, .., first + num_points - 1, in the camera frame, and
// their pixels. Of ViewJob the points and the pose are not used.
struct MapRowJob : ViewJob {
  long first = 0;
  double start[3] = {};
  double step[3] = {};
  float* x = nullptr;  // kNowhere outside the lens' domain
  float* y = nullptr;
};

// A row of pixels of a source picture of one or three values each, and where they go.
struct ResampleJob {
  const void* source = nullptr;
  long stride = 0;  // values from one row to the next
  int width = 0;
  int height = 0;
  const float* x = nullptr;
  const float* y = nullptr;
  long num_pixels = 0;
  void* target = nullptr;
  unsigned char* seen = nullptr;   // 255 where the coordinates are in the source, else 0
  const void* border = nullptr;    // the pixel that is written where they are not
  const float* phases = nullptr;   // of Lanczos: kPhases + 1 rows of kLanczosTaps weights
  const float* profile = nullptr;  // of Lanczos: kProfileSteps weights per unit of distance, to 4
};

inline constexpr int kLanczosTaps = 8;
inline constexpr int kPhases = 1024;
inline constexpr int kProfileSteps = 512;

// Kinds of pixels: 8 and 16 bits, one and three values.
enum PixelKind { kGrey8, kGrey16, kColour8, kColour16, kNumPixelKinds };

struct ReprojectKernels {
  using MapRow = void (*)(const MapRowJob&);
  using ResampleRow = void (*)(const ResampleJob&);
  // The mean about the coordinates of pixel i with the kernel widened, if that is fast: false, and
  // nothing written, if taps are beyond the border, or more than 16 in a row.
  using MeanPixel = bool (*)(const ResampleJob&, long i, float width);
  MapRow map_row[kNumKernelKinds] = {};
  ResampleRow nearest[kNumPixelKinds] = {};
  ResampleRow bilinear[kNumPixelKinds] = {};
  ResampleRow lanczos[kNumPixelKinds] = {};
  MeanPixel tent_mean[kNumPixelKinds] = {};
  MeanPixel lanczos_mean[kNumPixelKinds] = {};
};

extern const ReprojectKernels kPortableReprojectKernels;
extern const ReprojectKernels kAvx2ReprojectKernels;  // null pointers without AVX2

}  // namespace tagcal::internal
