#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/bundle/covariance.hpp"

// Evidence that the residuals of a solved bundle are not independent noise: a model that is too
// small, or a bent board.

namespace tagcal::internal {

// Bias of the residuals by place in the image: their means over the cells of a 12 x 8 grid, and the
// means of their radial parts over 16 rings about the principal point. Noise has no bias.
struct ResidualBias {
  double rms_px = 0;  // RMS of the means, less the part of the noise; the larger of grid and rings
  bool disagree = false;  // the means exceed noise (p = 0.0001), and policy::kLeastSigmaPx
};

// `least_sigma`: floor of the noise per (whitened) coordinate.
ResidualBias residual_bias(const Bundle& solved, double least_sigma);

// Compares two lenses of the bundle's model by the difference of their parameters and its
// covariance. The projections are compared at `samples`, at infinity and at the distance: there a
// motion of the camera takes the place of a focal length or of a principal point. No value if no
// sample has a ray.
std::optional<HalvesCheck> compare_lenses(const Bundle& solved, const Eigen::VectorXd& difference,
                                          const Eigen::MatrixXd& covariance,
                                          std::span<const Eigen::Vector2d> samples,
                                          double distance_m);

// Compares the solutions of two halves of the views (those of every other pose, and the rest), each
// one Gauss-Newton step from the common solution. Returns no value for fewer than six poses, or if
// a half does not determine the parameters.
std::optional<HalvesCheck> split_half_check(const Bundle& solved,
                                            const BundleInformation& information, double sigma,
                                            std::span<const Eigen::Vector2d> samples,
                                            double distance_m);

}  // namespace tagcal::internal
