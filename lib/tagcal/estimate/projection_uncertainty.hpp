#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// The standard deviation of each parameter of the lens: 0 for a held one, and where rounding made a
// variance negative.
std::vector<double> lens_sigmas(const UncertainLens& lens);

// The covariance of a lens by the free parameters of another model of its kind: each is the mean of
// the lens parameters that it sets; zero for parameters that the lens' own model holds.
MatrixX covariance_by(const Model& model, const UncertainLens& lens);

// Standard deviations of the projection over a grid and over the samples of a region, for points at
// one distance. Var(q) = A C A^T with A = J - J_pose (J_pose^T J_pose)^-1 J_pose^T J, where J is
// the Jacobian by the parameters, J_pose that by a pose (at infinity: a rotation) common to all
// points, and the products are sums over the samples (after mrcal's projection uncertainty: Kogan,
// https://mrcal.secretsauce.net). `samples` are pixels, three or more that are not on a line.
ProjectionUncertainty projection_uncertainty(const UncertainLens& lens, const ImageGrid& grid,
                                             std::span<const Eigen::Vector2d> samples,
                                             double distance_m);

// The matrix A above at the samples: two rows for each sample that has a ray.
MatrixX aligned_jacobian(const UncertainLens& lens, std::span<const Eigen::Vector2d> samples,
                         double distance_m);

}  // namespace tagcal
