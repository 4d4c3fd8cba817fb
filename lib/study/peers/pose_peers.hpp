#pragma once

#include <vector>

#include "study/tasks/calibration_tasks.hpp"
#include "study/tasks/pose_task.hpp"

// Poses by other libraries. Private to study.

namespace tagcal::study {

// cv::solvePnP by the name of its flag. IPPE and IPPE_SQUARE call cv::solvePnPGeneric, which
// returns both solutions of a plane; the better one is the answer.
PoseMethod opencv_pose(const std::string& flag);

// cv::solvePnPRansac by name: "solvePnPRansac" (the default, EPNP and ITERATIVE), the same with
// AP3P or SQPNP appended, "USAC (MSAC, inner LO)" or "USAC MAGSAC". The tolerance is 4 sigma, and
// the number of iterations is several times that needed for 50 % outliers.
PoseMethod opencv_ransac(const std::string& name);

// cv::calibrateCamera of one view with f free, OpenCV's only estimate of a focal length from one
// view. For points in space it needs six of them and an initial f; here the image's width.
PoseMethod opencv_calibrate_camera();

// AprilTag's estimate_tag_pose for squares with corners in the order of `square_points`. The
// homography is not timed, because the detector computes it anyway.
PoseMethod apriltag_pose();

// OpenGV's poses (Kneip and Furgale, ICRA 2014), if it is installed: the solution of upnp with the
// least residuals, and the same refined by optimize_nonlinear. Empty if the build did not find
// OpenGV.
std::vector<PoseMethod> opengv_poses();

// A plain Ceres solution, with automatic derivatives and one residual block per corner, to compare
// our Jacobians and sums with.

// cv::solvePnP SQPNP, then Ceres: AutoDiffCostFunction, EigenQuaternionManifold, DENSE_QR.
PoseMethod ceres_autodiff_pose();

// Model opencv5: initial poses by cv::solvePnP with the true f (as for mrcal), then Ceres:
// AutoDiffCostFunction, DENSE_SCHUR.
CalibrationMethod ceres_autodiff_calibration();

}  // namespace tagcal::study
