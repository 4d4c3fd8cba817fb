#pragma once

#include <Eigen/Core>

#include "tagcal/estimate/pose/reprojection.hpp"

namespace tagcal::internal {

// Writes the Jacobian of a view's rows by the shapes of its board (ViewShapes) into the columns of
// `all` from `first` on. `by_pose`: the Jacobian by (omega, tau) of `retract`.
inline void set_shape_columns(const ViewShapes& shapes, const Pose& pose, const RowMajor6& by_pose,
                              Eigen::Index first, Eigen::MatrixXd& all) {
  const Eigen::Vector3d normal = pose.rotation() * shapes.normal;
  const Eigen::Vector3d across = pose.rotation() * shapes.across;
  for (std::size_t i = 0; i < shapes.of_points.size(); ++i)
    for (Eigen::Index k = 0; k < shapes.of_points[i].size(); ++k)
      all.block<2, 1>(static_cast<Eigen::Index>(2 * i), first + k) =
          shapes.of_points[i][k] *
          by_pose.middleRows<2>(static_cast<Eigen::Index>(2 * i)).rightCols<3>() *
          (k < 3 ? normal : across);
}

}  // namespace tagcal::internal
