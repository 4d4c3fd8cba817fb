#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal {

// The print about a place where four squares of a checkerboard meet, as a grid of cells. The place
// is (0, 0), and a line of each direction passes through it; any unit, any handedness. Everything
// beyond the outermost lines is unknown.
struct CornerPattern {
  std::vector<double> columns, rows;    // borders of the cells in x and in y, ascending, 3 to 24
  std::vector<TagPattern::Cell> cells;  // (columns - 1) x (rows - 1), by rows from the lowest y
};

struct CornerFit {
  TagFitStatus status = TagFitStatus::not_converged;
  // Only if converged:
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();          // pixel centres at whole numbers
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  // from the residuals
  double blur_px = 0;  // sd of the Gaussian without the pixel's square
  double black = 0;    // grey levels at the corner
  double white = 0;
  double noise_levels = 0;  // sd of a pixel about the model
  int num_pixels = 0;
};

// Finds a corner of a checkerboard by fitting the pixels about it, up to 40 px on each side, with
// the model of refine_tag(): the pattern under a homography and slight bends, blurred by a Gaussian
// and the pixel's square, times a gain that changes linearly, plus an offset. `image_from_pattern`
// is approximate: to a quarter of a square at the corner, to about 3 % in scale. Without a camera
// in the options the bends are estimated, which costs half as much again in standard deviation.
// Throws Error for a pattern of another shape, or a camera of another size than the picture.
CornerFit refine_corner(const ImageView8& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern,
                        const TagFitOptions& options = {});
CornerFit refine_corner(const ImageView16& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern,
                        const TagFitOptions& options = {});

}  // namespace tagcal
