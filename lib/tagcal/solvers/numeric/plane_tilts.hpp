#pragma once

#include <Eigen/Core>
#include <optional>

namespace tagcal::internal {

// What `ippe` finds, as numbers: both rotations of a plane and the translation that they share.
struct PlaneTilts {
  Eigen::Matrix3d rotation[2];
  Eigen::Vector3d translation;
};
std::optional<PlaneTilts> ippe_tilts(const Eigen::Matrix3d& camera_from_plane);

}  // namespace tagcal::internal
