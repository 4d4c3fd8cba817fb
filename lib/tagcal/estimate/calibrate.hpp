#pragma once

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// Throws Error for what `calibrate` refuses whatever the data set: a model that is not known, a
// board that `weak` should bend, a distance that is not positive, a tolerance that is negative or
// without `auto`, a parameter to hold that the model does not have, a start of another kind of
// lens.
void check_options(const CalibrateOptions& options);

// Camera and all poses from the observations of one data set: closed-form start on consensus,
// maximum likelihood by Ceres, corners beyond 5 sigma rejected and the rest solved again,
// covariance from the exact inverse of the information. Model `weak` asked for by its name is an
// answer (ok): a scaled orthographic pose for each view, and no focal length. Throws Error as
// `check_options` does, for a board_warp of anything but one flat board, and for a start of another
// image size.
Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options = {});

}  // namespace tagcal
