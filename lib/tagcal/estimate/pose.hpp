#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/types.hpp"

// Where one view was taken from, and with what focal length: the most likely answer, how sure it
// is, and what the view cannot tell.

namespace tagcal {

// The pose of a calibrated camera before a target, from four points or more that are not on a line.
// Every point of an answer lies in the lens' domain, in front of the camera. Neither the unit of
// length nor the target's place in its frame matters.
PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options = {});

// Pose and focal length of a pinhole with square pixels and its principal point in the centre of
// the image, from four points or more: in a plane that is tilted enough, or in space. The focal
// length is refused (focal_not_observable) where sd(f) / f exceeds 10 % at the estimate, where weak
// perspective explains the view as well, or where the residuals show that the lens is no pinhole.
PoseAndFocalEstimate estimate_pose_and_focal(std::span<const Correspondence> correspondences,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options = {});

}  // namespace tagcal
