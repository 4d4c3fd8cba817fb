#pragma once

#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// The standard deviation of the velocities (px a row, in units of Bundle::row_prior) with which the
// camera moved while a rolling shutter read the rows, or 0 if the views show none; of a bundle that
// was solved without row terms. The residuals of a view are, to first order, a step of its pose, a
// field that all views share (the lens, a skew of the sensor), noise, and two normal effects of the
// view: a velocity times the row, of variance r^2, and a velocity times the column, of variance
// c^2. The restricted likelihood (Patterson & Thompson, Biometrika 1971) of r > c is compared with
// that of r = c: errors of board, corners and focus prefer neither rows nor columns, a rolling
// shutter has rows only.
double rolling_sigma_of(const Bundle& solved, int max_iterations, std::size_t num_threads);

// The largest displacement of a corner of each view by the velocity of its view, against the middle
// row (px).
std::vector<double> row_motions_px(const Bundle& solved);

}  // namespace tagcal::internal
