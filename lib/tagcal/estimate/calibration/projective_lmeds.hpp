#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/solvers/numeric/point_spread.hpp"

namespace tagcal::internal {

// Returns the inliers, ascending, of a projective map from a plane or from space to rays: `ransac`
// with the least median of squares (Rousseeuw 1984) of the direct linear transformation. It needs
// no noise level, so distortion makes no outliers, and it tolerates just under half of wrong
// correspondences. Points are relative to their centre, those of a plane at z = 0 or nearly so;
// rays are directions. Deterministic. No value if no sample determines a map.
std::optional<std::vector<std::size_t>> projective_lmeds(std::span<const Eigen::Vector3d> points,
                                                         PointShape shape,
                                                         std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal::internal
