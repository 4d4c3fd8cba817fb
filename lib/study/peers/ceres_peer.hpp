#pragma once

#include "study/tasks/calibration_tasks.hpp"
#include "study/tasks/pose_task.hpp"

// A plain Ceres solution, with automatic derivatives and one residual block per corner, to compare
// our Jacobians and sums with. Private to study.

namespace tagcal::study {

// cv::solvePnP SQPNP, then Ceres: AutoDiffCostFunction, EigenQuaternionManifold, DENSE_QR.
PoseMethod ceres_autodiff_pose();

// Model opencv5: initial poses by cv::solvePnP with the true f (as for mrcal), then Ceres:
// AutoDiffCostFunction, DENSE_SCHUR.
CalibrationMethod ceres_autodiff_calibration();

}  // namespace tagcal::study
