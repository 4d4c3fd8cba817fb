#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/estimate/n_point.hpp"
#include "tagcal/estimate/planar.hpp"
#include "tagcal/estimate/point_spread.hpp"

// Linear solutions, exact without noise. Image points come as rays: directions in the camera frame
// of any length but zero, (x, y, 1) for a pinhole, so that a view beyond 180 degrees is no
// exception.

namespace tagcal {

// M (3 x d) with ray_i ~ M x_i for homogeneous points, the columns of x (d x n, last row 1), by the
// normalised direct linear transformation (Hartley & Zisserman 2004, section 4.1), the sign such
// that the points lie in front. Needs d = 3: four, d = 4: six points; no value where they do not
// fix M.
std::optional<Eigen::MatrixXd> projective_map(const Eigen::MatrixXd& x,
                                              std::span<const Eigen::Vector3d> rays);

// The pose of any set of points by the solver that fits its shape; no value for a line, or where
// there are too few points (four in a plane, six in space).
std::optional<Pose> pose_closed_form(std::span<const Eigen::Vector3d> points,
                                     std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal
