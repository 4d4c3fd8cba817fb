#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/seen_region.hpp"

namespace tagcal {

inline constexpr double kInfinitelyFar = std::numeric_limits<double>::infinity();

// A lens, and how well its free parameters are known.
struct UncertainLens {
  const Model* model = nullptr;
  Lens lens = pinhole(1, 1, 0, 0);
  MatrixX covariance;  // of the model's free parameters
};

// Standard deviation of the projection, in pixels per coordinate, at every node of a grid: of the
// point that the lens sees there at a distance along its ray. What a moved and turned camera
// explains is taken out: nobody who uses the lens would see it, the pose takes it up.
struct ProjectionUncertainty {
  double distance_m = kInfinitelyFar;
  ImageGrid grid;
  MatrixX sigma_px;          // rows x columns; NaN where no ray meets the pixel
  double region_px = 0;      // RMS over the samples of the region; infinite where it has none
  double region_max_px = 0;  // the largest over them
};

// Var(q) = A C A^T, A = J - J_pose (J_pose^T J_pose)^-1 J_pose^T J with the products over the
// samples of the region, J by the parameters and J_pose by a pose (at infinity: a rotation) common
// to all points (after mrcal's projection uncertainty: Kogan, https://mrcal.secretsauce.net).
// `samples` are pixels, three or more that are not on a line.
ProjectionUncertainty projection_uncertainty(const UncertainLens& lens, const ImageGrid& grid,
                                             std::span<const Eigen::Vector2d> samples,
                                             double distance_m);

// A as above at the samples themselves (two rows each; those without a ray left out).
MatrixX aligned_jacobian(const UncertainLens& lens, std::span<const Eigen::Vector2d> samples,
                         double distance_m);

}  // namespace tagcal
