#pragma once

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// Throws Error for options that `calibrate` refuses for every data set: an unknown model,
// board_warp with model weak, a distance that is not positive, a tolerance that is negative or
// without `auto`, a fixed parameter that the model does not have, a start with another kind of
// lens.
void check_options(const CalibrateOptions& options);

// Estimates the camera and all poses from one data set: closed-form start from the inliers of least
// median of squares, bundle adjustment by Ceres, corners beyond 5 sigma rejected and the rest
// solved again, choice of the model, covariance from the exact inverse of the information, checks.
// Model `weak` by its name is an answer (ok): a scaled orthographic pose for each view, and no
// focal length. Throws Error as `check_options` does, for board_warp without exactly one flat
// board, and for a start with another image size.
Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options = {});

// The error of a projection by the calibrated camera per coordinate, besides the noise of a corner:
// the error of lens and target that the residuals show (all of the residuals if the corners had no
// covariances) and the projection's uncertainty at the corners' distance. view_correspondences
// (view_correspondences.hpp) takes it.
double camera_error_px(const Calibration& calibration);

}  // namespace tagcal
