#pragma once

#include "study/tasks/calibration_tasks.hpp"
#include "study/tasks/pose_task.hpp"

// Ceres as one writes it in an afternoon: derivatives by Jets, one residual block a corner. What
// our Jacobians and sums are worth beside it. Private to study.

namespace tagcal::study {

// cv::solvePnP SQPNP, then Ceres: AutoDiffCostFunction, EigenQuaternionManifold, DENSE_QR.
PoseMethod ceres_autodiff_pose();

// The poses by cv::solvePnP, the true f given (mrcal's start), then Ceres: AutoDiffCostFunction,
// DENSE_SCHUR. Of model opencv5.
CalibrationMethod ceres_autodiff_calibration();

}  // namespace tagcal::study
