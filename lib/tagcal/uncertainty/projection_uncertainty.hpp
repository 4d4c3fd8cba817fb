#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "tagcal/uncertainty/seen_region.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal {

inline constexpr double kInfinitelyFar = std::numeric_limits<double>::infinity();

// Standard deviation of the projection (px per coordinate) at the nodes of a grid: that of the
// point at a distance along the ray of the node. The part that a moved and rotated camera explains
// is subtracted, because the pose absorbs it in any use of the lens.
struct ProjectionUncertainty {
  double distance_m = kInfinitelyFar;
  ImageGrid grid;
  MatrixX sigma_px;          // rows x columns; NaN if the node has no ray
  double region_px = 0;      // RMS over the samples of the region; infinite without samples
  double region_max_px = 0;  // largest over the samples
};

// Standard deviations of the projection over a grid and over the samples of a region, for points at
// one distance. Var(q) = A C A^T with A = J - J_pose (J_pose^T J_pose)^-1 J_pose^T J, where J is
// the Jacobian by the parameters, J_pose that by a pose (at infinity: a rotation) common to all
// points, and the products are sums over the samples (after mrcal's projection uncertainty: Kogan,
// https://mrcal.secretsauce.net). `samples` are pixels, three or more that are not on a line.
ProjectionUncertainty projection_uncertainty(const UncertainCamera& known, const ImageGrid& grid,
                                             std::span<const Eigen::Vector2d> samples,
                                             double distance_m);

// The matrix A above at the samples: two rows for each sample that has a ray.
MatrixX aligned_jacobian(const UncertainCamera& known, std::span<const Eigen::Vector2d> samples,
                         double distance_m);

// A weakly determined combination of parameters.
struct WeakDirection {
  std::string parameter;  // the one with the largest effect on the projection
  double sigma_px = 0;    // its effect on the projection at infinity, RMS over the seen region
  std::string sentence;   // the parameters that are correlated, and a remedy
};

// The at most three least determined combinations of parameters, by their effect on the projection
// at infinity over the samples (pixels), the largest first.
std::vector<WeakDirection> weak_directions(const UncertainCamera& known,
                                           std::span<const Eigen::Vector2d> samples);

}  // namespace tagcal
