#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::internal {

// How many pixels beside its own the blur of a pixel takes in at most.
int blur_reach_px(double blur_px);

// Applies a Gaussian blur (standard deviation blur_px > 0, in pixels) and a factor to a raster
// `scale` times finer than the image and samples it at the pixels. The last cell is repeated beyond
// the border. The raster comes row by row, and memory holds only the rows that a pixel needs.
class Blur {
 public:
  // The image must outlive it.
  Blur(double blur_px, int scale, float factor, ImageF& image);

  // Takes the next row of the raster, scale * width cells, whose levels change only in the blocks
  // `passed` (CoverageBand).
  void add_row(const float* cells, std::span<const std::uint64_t> passed);

  // Completes the pixels at the lower border after the last row.
  void finish();

 private:
  void filter_row(const float* cells, std::span<const std::uint64_t> passed);
  float* add_step(int cell, float before, float level, float* first);
  void repeat_row();

  ImageF& image_;
  int scale_;
  int reach_;                 // cells that count on either side of a pixel
  int tail_ = 0;              // pixels that a change of level between two cells affects
  std::vector<float> tails_;  // for each phase of the change, the weights beyond it at those pixels
  std::vector<float> row_;    // pixels of the filtered row, with tail_ more at either end
  Eigen::VectorXf weights_;   // of the cells from -reach_ on, counted from the pixel's first
  Eigen::MatrixXf window_;    // filtered rows as columns, each twice: those of a pixel are adjacent
  Eigen::Index num_rows_ = 0;
};

}  // namespace tagcal::internal
