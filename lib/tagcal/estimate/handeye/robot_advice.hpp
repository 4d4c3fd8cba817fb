#pragma once

#include <optional>

#include "tagcal/estimate/handeye/handeye_bundle.hpp"

namespace tagcal::internal {

// The pose of the robot after which the camera's place has the least covariance (determinant), of
// poses from which the camera looks at the board's centre, at its median distance, from 17
// directions and turned about its axis in four ways; the board must be in the picture, and the hand
// not much further away than it has been. Its standard deviations are those of the answer, in the
// ratio of what the views predict with and without the pose. No value if none is possible.
std::optional<AdvisedRobotPose> advise_robot_pose(const HandeyeProblem& problem,
                                                  const HandeyeState& state,
                                                  const RobotNoise& noise,
                                                  const HandeyeEstimate& answer);

}  // namespace tagcal::internal
