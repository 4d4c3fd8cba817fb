#pragma once

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// Rejects views that a fit explains much worse than the others, as when the board moved during the
// exposure: their inliers alone would bias the model. A view is outlying if
//   - the RMS of its inliers is policy::kMuchLargerSd medians and its residuals are spatially
//     correlated (residual_test.hpp): large noise alone is no reason; or
//   - policy::kMinority more of its largest board's corners than usual are rejected.
// If more than a third of the views are outlying, the model is wrong, and none is rejected. Rejects
// a board of a view if most of its corners are outliers and those of the largest board are not: its
// pose differs from the data set's. Rejected corners stand in input.rejected with their residuals
// under this fit. Returns true if any was rejected.
bool reject_outlying_views(CalibrationInput& input, const CalibrationFit& fit,
                           const CalibrateOptions& options);

}  // namespace tagcal::internal
