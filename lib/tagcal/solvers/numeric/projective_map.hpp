#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace tagcal::internal {

// Rays are directions in the camera frame of any length but zero.
// M (3 x d) with ray_i ~ M x_i for homogeneous points, the columns of x (d x n, last row 1), by the
// normalised direct linear transformation (Hartley & Zisserman 2004, section 4.1), the sign such
// that the points lie in front. Needs d = 3: four, d = 4: six points; no value where they do not
// fix M.
std::optional<Eigen::MatrixXd> projective_map(const Eigen::MatrixXd& x,
                                              std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal::internal
