#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tagcal {

// Which correspondences a projective map (plane or space to rays) agrees on.
struct Consensus {
  std::vector<std::uint8_t> inlier;  // per correspondence
  double median_rad = 0;             // median angle between the rays and the map, over all
};

// Least median of squares (Rousseeuw 1984) over minimal samples of the direct linear
// transformation: it needs no noise level, so what a lens bends is not taken for outliers, and
// stands up to just under half of the correspondences being wrong. Points are homogeneous columns
// (3 x n in a plane, 4 x n in space), rays are directions. Deterministic. No value where no sample
// fixes a map.
std::optional<Consensus> find_consensus(const Eigen::MatrixXd& points,
                                        std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal
