#pragma once

#include "study/tasks/pose_task.hpp"

namespace tagcal::study {

// cv::solvePnP by the name of its flag; IPPE and IPPE_SQUARE by cv::solvePnPGeneric, which returns
// both solutions of a plane as ours do (the better one counts).
PoseMethod opencv_pose(const std::string& flag);

// cv::solvePnPRansac: "solvePnPRansac" (its default, EPNP and ITERATIVE), with AP3P or SQPNP behind
// the name, "USAC (MSAC, inner LO)" or "USAC MAGSAC". The tolerance suits the noise, and iterations
// are enough for half of the points being wrong several times over.
PoseMethod opencv_ransac(const std::string& name);

// cv::calibrateCamera of one view, f free: the only way of OpenCV to a focal length from one view.
// In space it takes six points and asks for a guess of f, which is the image's width.
PoseMethod opencv_calibrate_camera();

}  // namespace tagcal::study
