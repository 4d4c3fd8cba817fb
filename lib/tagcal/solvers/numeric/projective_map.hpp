#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace tagcal::internal {

// Returns M (3 x d) with ray_i ~ M x_i for homogeneous points, the columns of x (d x n, last row
// 1), by the normalised direct linear transformation (Hartley & Zisserman 2004, section 4.1). Its
// sign puts the points in front. Needs four points for d = 3, six for d = 4; no value if they do
// not determine M. Rays are directions in the camera frame of any length but zero.
std::optional<Eigen::MatrixXd> projective_map(const Eigen::MatrixXd& x,
                                              std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal::internal
