#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/solvers/numeric/point_spread.hpp"

namespace tagcal::internal {

// The inliers of a projective map from a plane or from space to rays.
struct Consensus {
  std::vector<std::uint8_t> inlier;  // per correspondence
  double median_rad = 0;             // median angle between the rays and the map, over all
};

// Least median of squares (Rousseeuw 1984) over minimal samples of the direct linear
// transformation. It needs no noise level, so distortion makes no outliers, and it tolerates just
// under half of wrong correspondences. Points are relative to their centre, those of a plane at
// z = 0 or nearly so; rays are directions. Deterministic. No value if no sample determines a map.
std::optional<Consensus> projective_lmeds(std::span<const Eigen::Vector3d> points, PointShape shape,
                                          std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal::internal
