#pragma once

#include "tagcal/geometry/pose.hpp"

namespace tagcal {

// The pose of a camera at `eye` that looks at `target`, image upright with respect to `up`, all in
// world coordinates. Camera axes as everywhere: x right, y down, z forward. Throws Error where eye
// and target coincide or where up is parallel to the view.
Pose camera_from_world_looking_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                                  const Eigen::Vector3d& up);

}  // namespace tagcal
