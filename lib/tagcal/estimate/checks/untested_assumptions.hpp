#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal::internal {

// What a model holds is taken for granted, and standard deviations are those of the model: where
// the views could not tell, and it matters, a sentence says so.

// For a solved bundle of one focal length, whose principal point is taken to be the centre of the
// image: where the views do not hold it (f+c is not held), or hold it so loosely that a principal
// point which is not known better, within what cameras have, would make the standard deviation of
// the focal length half as large again. No value where they tell, or for another model.
std::optional<std::string> assumed_centre(const Bundle& solved, double sigma);

// Whether the projection at the corners of the image is known to 0.5 % of its diagonal (one
// standard deviation, at infinity), and would be known to half a pixel, or half as much again as it
// is, if a perspective that is smaller than opencv5 were one: a distortion that the views tell they
// tell where their corners are, and `auto` takes it; what it does beyond them nobody has seen. A
// sentence where not. `samples`: as those of `projection_uncertainty`.
std::optional<std::string> extrapolated_corners(const Bundle& solved, double sigma,
                                                const UncertainLens& lens,
                                                std::span<const Eigen::Vector2d> samples);

}  // namespace tagcal::internal
