#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

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
