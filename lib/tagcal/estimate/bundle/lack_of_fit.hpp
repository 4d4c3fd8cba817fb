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

// Compares the solutions of two halves of the views (those that are in the second one, and the
// rest), each one Gauss-Newton step from the common solution. The projections are compared at
// `samples` and at the distance. Returns no value for fewer than three views in a half, or if a
// half does not determine the parameters.
std::optional<HalvesCheck> split_half_check(const Bundle& solved,
                                            const BundleInformation& information, double sigma,
                                            std::span<const Eigen::Vector2d> samples,
                                            double distance_m, const std::vector<bool>& is_second);

}  // namespace tagcal::internal
