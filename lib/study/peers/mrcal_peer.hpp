#pragma once

#include <array>
#include <vector>

// mrcal's optimiser (libmrcal, if installed) for views of one regular grid of points.

namespace tagcal::study {

struct MrcalProblem {
  int width = 0, height = 0;  // of the image
  int grid_columns = 0, grid_rows = 0;
  double spacing_m = 0;
  double focal_px = 0;         // initial value
  std::vector<double> pixels;  // x, y and weight (< 0: not seen), row by row of the grid, by views
  std::vector<double> poses;   // initial values: 6 per view, Rodrigues vector and translation
};

// Returns false if the build did not find libmrcal.
bool has_mrcal();

// fx fy cx cy k1 k2 p1 p2 k3 of LENSMODEL_OPENCV5, without regularisation and outlier rejection, in
// the three stages of mrcal's own tool: poses; then the pinhole with them; then all.
std::array<double, 9> mrcal_intrinsics(const MrcalProblem& problem);

}  // namespace tagcal::study
