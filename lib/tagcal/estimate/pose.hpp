#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/types.hpp"

// Pose, and focal length, of the camera of one view: the most likely answer, its covariance, and
// the reason where the view does not determine it.

namespace tagcal {

// Returns the pose of a calibrated camera before a target, from four points or more that are not on
// a line. Every point of an answer lies in the lens' domain, in front of the camera. The answer
// does not depend on the unit of length or on the place of the target in its frame.
PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options = {});

// Returns pose and focal length of a pinhole with square pixels and its principal point in the
// centre of the image, from four points or more: in a plane that is tilted enough, or in space. The
// focal length is refused (focal_not_observable) if sd(f) / f exceeds 10 % at the estimate, if weak
// perspective explains the view as well, or if the residuals show that the lens is no pinhole.
PoseAndFocalEstimate estimate_pose_and_focal(std::span<const Correspondence> correspondences,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options = {});

}  // namespace tagcal
