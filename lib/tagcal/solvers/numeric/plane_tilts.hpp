#pragma once

#include <Eigen/Core>
#include <optional>

namespace tagcal::internal {

// The result of `ippe` as numbers: both rotations of a plane and their common translation.
struct PlaneTilts {
  Eigen::Matrix3d rotation[2];
  Eigen::Vector3d translation;
};
std::optional<PlaneTilts> ippe_tilts(const Eigen::Matrix3d& camera_from_plane);

}  // namespace tagcal::internal
