#pragma once

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// What the residuals of a solved bundle have in common from place to place in the image: their
// means over the cells of a 12 x 8 grid, and radially over 16 rings about the principal point.
// Noise has none of its own; a lens that is too small, or a bent board, has.
struct ResidualField {
  double rms_px = 0;      // of the means, less what noise makes of them; the larger of both
  bool disagree = false;  // beyond p = 0.0001 of noise, and 0.02 px
  // Where they disagree: the variance of the means over what independent residuals of the same RMS
  // would have, >= 1; the larger of both. Chi-squares and covariances that count residuals as
  // independent are wrong by this (the variance inflation factor of quasi-likelihood: Burnham &
  // Anderson 2002, section 2.5; Kish's design effect).
  double inflation = 1;
};

// `least_sigma`: per (whitened) coordinate, below which a noise is not believed.
ResidualField residual_field(const Bundle& solved, double least_sigma);

}  // namespace tagcal::internal
