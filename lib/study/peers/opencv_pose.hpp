#pragma once

#include "study/tasks/pose_task.hpp"

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

}  // namespace tagcal::study
