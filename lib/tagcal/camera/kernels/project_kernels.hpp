#pragma once

// The kernels of batch projection, compiled once for any processor, once for x86-64 with AVX2 and
// FMA; project_dispatch.cpp chooses at run time. This header has only plain data and pointers, no
// Eigen and no standard library (see internal/pack.hpp).

namespace tagcal::internal {

inline constexpr int kMaxLensParameters = 12;
inline constexpr int kNumShapes = 4;  // of a target
inline constexpr int kMaxRowTerms = 6;

// n points and the camera that sees them; the caller's arrays, row-major.
struct ViewJob {
  unsigned long num_points = 0;
  const double* points = nullptr;  // n x 3, in the source frame
  double rotation[9] = {};         // camera_from_source, row by row
  double translation[3] = {};
  double parameters[kMaxLensParameters] = {};
  double limit = 0;  // of the domain, as the lens' kernel has it
};

// Memory for the results.
struct ProjectJob : ViewJob {
  double* pixels = nullptr;         // n x 2
  unsigned char* valid = nullptr;   // n
  double* by_pose = nullptr;        // 2n x 6, or null: not wanted
  double* by_parameters = nullptr;  // 2n x num_columns, or null: not wanted
  int num_columns = 0;
  unsigned columns[kMaxLensParameters] = {};  // bit j: lens parameter j is part of this column
};

// The normal equations of the residuals, projected - observed pixel: sums over all points of the
// products of the columns of [J | r], the upper triangle row by row: N (N + 1) / 2 numbers for N
// columns. J has the derivatives by the pose step (6) and
//   sums_pose             no others: N = 7
//   sums_pose_and_focal   by the logarithm of the focal length (fx and fy change by one factor)
//   sums_with_parameters  by free parameters; by four shapes of the target, if there are; and by
//                         row terms, if there are, which act in proportion to the row of a pixel:
//                         two that move it along u and along v, or six that move the pose:
//                         N = 6 + num_columns + (shape ? kNumShapes : 0) + row_terms + 1
struct SumJob : ViewJob {
  const double* pixels = nullptr;     // n x 2, observed
  const double* whitening = nullptr;  // n x 4, W (column by column) of rows W [J | r], or null: 1
  double* sums = nullptr;
  int num_columns = 0;
  unsigned columns[kMaxLensParameters] = {};  // bit j: lens parameter j is part of this column
  // n x 4, or null: how far a point moves by a unit of each shape; the first three along
  // shape_directions[0], the last one along shape_directions[1] (camera frame).
  const double* shape = nullptr;
  double shape_directions[2][3] = {};
  int row_terms = 0;      // 2, 6 or none
  double middle_row = 0;  // the row that does not move
};

// The terms that a kernel computes. kPinhole omits the distortion and kBrownConrady its denominator
// (k4 k5 k6), in the values and in the columns.
enum ProjectKernelKind {
  kPinhole,
  kBrownConrady,
  kRational,
  kFisheye,
  kParallel,
  kDoubleSphere,
  kExtendedUnified,
  kNumKernelKinds
};

struct ProjectKernels {
  using Kernel = void (*)(const ProjectJob&);
  using SumKernel = bool (*)(const SumJob&);    // false: a point is out of the domain
  Kernel pixels[kNumKernelKinds] = {};          // leaves the Jacobians alone
  Kernel with_jacobians[kNumKernelKinds] = {};  // those that are wanted
  SumKernel sums_pose[kNumKernelKinds] = {};
  SumKernel sums_pose_and_focal[kNumKernelKinds] = {};
  SumKernel sums_with_parameters[kNumKernelKinds] = {};
};

extern const ProjectKernels kPortableKernels;
extern const ProjectKernels kAvx2Kernels;  // null pointers where the compiler has no AVX2

}  // namespace tagcal::internal
