#pragma once

#include <array>
#include <vector>

// mrcal's optimiser (libmrcal, where it is installed) on views of one regular grid of points.

namespace tagcal::study {

struct MrcalProblem {
  int width = 0, height = 0;  // of the image
  int grid_columns = 0, grid_rows = 0;
  double spacing_m = 0;
  double focal_px = 0;         // where it starts
  std::vector<double> pixels;  // x, y and weight (< 0: not seen), row by row of the grid, by views
  std::vector<double> poses;   // where they start: 6 a view, Rodrigues vector and translation
};

// False: there was no libmrcal when this was built.
bool has_mrcal();

// fx fy cx cy k1 k2 p1 p2 k3 of LENSMODEL_OPENCV5, without regularisation and without looking for
// outliers: all at once, or in the stages of mrcal's own tool, which do not need a start as good
// (poses; then the pinhole with them; then all).
enum class MrcalStages { one, three };
std::array<double, 9> mrcal_intrinsics(const MrcalProblem& problem, MrcalStages stages);

}  // namespace tagcal::study
