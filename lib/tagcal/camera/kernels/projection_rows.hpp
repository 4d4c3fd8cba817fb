#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {

using RowMajor6 = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;
using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Pixels of n points, and their Jacobians (two rows a point) by (omega, tau) of `retract` and by
// the free parameters of a model.
struct ProjectionRows {
  std::vector<Eigen::Vector2d> pixels;
  RowMajor6 by_pose;
  RowMajorX by_parameters;
};

// As project_with_jacobians. No value if a point is outside the lens' domain.
std::optional<ProjectionRows> projection_rows(const Lens& lens, const Pose& camera_from_source,
                                              std::span<const Eigen::Vector3d> x_in_source,
                                              std::span<const FreeParameter> free = {});

}  // namespace tagcal::internal
