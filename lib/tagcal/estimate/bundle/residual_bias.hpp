#pragma once

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// Bias of the residuals of a solved bundle by place in the image: their means over the cells of a
// 12 x 8 grid, and the means of their radial parts over 16 rings about the principal point. Noise
// has no bias; a model that is too small, or a bent board, causes one.
struct ResidualBias {
  double rms_px = 0;  // RMS of the means, less the part of the noise; the larger of grid and rings
  bool disagree = false;  // the means exceed noise (p = 0.0001), and policy::kLeastBiasPx
  // If `disagree`: the variance of the means over that of independent residuals of the same RMS, >=
  // 1; the larger of grid and rings. Chi-squares and covariances that take residuals as independent
  // are too large or too small by this factor (variance inflation factor of quasi-likelihood:
  // Burnham & Anderson 2002, section 2.5; Kish's design effect).
  double inflation = 1;
};

// `least_sigma`: floor of the noise per (whitened) coordinate.
ResidualBias residual_bias(const Bundle& solved, double least_sigma);

}  // namespace tagcal::internal
