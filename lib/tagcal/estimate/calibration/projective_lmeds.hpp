#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/solvers/numeric/point_spread.hpp"

namespace tagcal::internal {

// Which correspondences a projective map (plane or space to rays) agrees on.
struct Consensus {
  std::vector<std::uint8_t> inlier;  // per correspondence
  double median_rad = 0;             // median angle between the rays and the map, over all
};

// Least median of squares (Rousseeuw 1984) over minimal samples of the direct linear
// transformation: it needs no noise level, so what a lens bends is not taken for outliers, and
// stands up to just under half of the correspondences being wrong. Points are about their centre
// and, of a plane, at z = 0 or nearly so; rays are directions. Deterministic. No value where no
// sample fixes a map.
std::optional<Consensus> find_consensus(std::span<const Eigen::Vector3d> points, PointShape shape,
                                        std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal::internal
