#pragma once

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// Views that a fit explains much worse than the others, corner by corner rejection notwithstanding,
// as when the board moved during the exposure: they would bend the model. A view stands out
//   - by an RMS of its inliers of 1.3 medians (or of the least noise that may be) and spatially
//     correlated residuals (agreement.hpp): noise alone, however large, is no reason, or
//   - where 40 points of percent more of its largest board were rejected than usual, or 30 with
//     spatially correlated residuals.
// Where more than a third of the views do so, it is not the views that are wrong. Of several boards
// those are left out of a view that were rejected for the most part while the largest was not:
// they do not hang where the data set says. What is left out stands in input.dropped with its
// residuals under this fit; says whether there was any.
bool leave_out_what_stands_out(CalibrationInput& input, const CalibrationFit& fit,
                               const CalibrateOptions& options);

// Whether a fit explains what was left out of its input by another lens: all of its corners agree,
// and without those the model's sum of squares is lower by no more than noise makes of them
// (p = 0.001; Chow, Econometrica 1960). Then the other lens was wrong, and not the views.
bool explains_left_out(const CalibrationFit& fit, const CalibrationInput& without,
                       const CalibrateOptions& options);

}  // namespace tagcal::internal
