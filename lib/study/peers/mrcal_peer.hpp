#pragma once

#include <array>
#include <vector>

// mrcal's optimiser (libmrcal, if installed) for cameras on one body before a regular grid of
// points.

namespace tagcal::study {

struct MrcalView {
  int frame = 0, camera = 0;
};

struct MrcalProblem {
  int width = 0, height = 0;  // of the images
  int grid_columns = 0, grid_rows = 0;
  double spacing_m = 0;
  double focal_px = 0;  // initial value
  int num_cameras = 1;
  std::vector<MrcalView> views;  // by frame, then camera
  std::vector<double> pixels;  // x, y and weight (< 0: not seen), row by row of the grid, by views
  // Initial values, a Rodrigues vector and a translation each: of the grid in the first camera, by
  // frame; of the other cameras, from the first.
  std::vector<double> poses, camera_from_first;
};

struct MrcalAnswer {
  std::vector<std::array<double, 9>> intrinsics;  // fx fy cx cy k1 k2 p1 p2 k3, by camera
  std::vector<double> camera_from_first;          // as in MrcalProblem
};

// Returns false if the build did not find libmrcal.
bool has_mrcal();

// LENSMODEL_OPENCV5, without regularisation and outlier rejection, in the three stages of mrcal's
// own tool: poses; then the pinhole with them; then all.
MrcalAnswer calibrate_by_mrcal(const MrcalProblem& problem);

}  // namespace tagcal::study
