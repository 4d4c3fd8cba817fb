#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal::internal {

// A model fixes some parameters, and its standard deviations take them as exact. These functions
// return a sentence if the views cannot test such an assumption and it matters.

// For a solved bundle of model f, which fixes the principal point at the centre of the image. The
// sentence says that the views do not determine it (f+c is not observable), or so loosely that the
// standard deviation of the focal length would be half as large again with a free principal point
// (with the spread that cameras have as its prior). No value otherwise, or for another model.
std::optional<std::string> untested_principal_point(const Bundle& solved, double sigma);

// Returns a sentence if the standard deviation of the projection at the corners of the image (at
// infinity) exceeds 0.5 % of its diagonal; or, for a perspective smaller than opencv5, if it would
// exceed half a pixel and 1.5 times its value with opencv5's coefficients free. The views show
// distortion only where their corners are. `samples`: as those of `projection_uncertainty`.
std::optional<std::string> extrapolated_corners(const Bundle& solved, double sigma,
                                                const UncertainLens& lens,
                                                std::span<const Eigen::Vector2d> samples);

}  // namespace tagcal::internal
