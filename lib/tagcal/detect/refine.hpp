#pragma once

#include <Eigen/Core>
#include <array>

#include "tagcal/detect/types.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal {

// The pattern of a tag, with a border of `border_bits` whatever the width of the family's border.
// Throws Error if the family lacks the id, or cannot have the border or the squares.
TagPattern tag_pattern(const TagFamily& family, int id, int border_bits,
                       const TagSurroundings& surroundings = {});

// Finds the corners of a tag whose pattern is known by fitting all of its pixels: grey level = the
// pattern under a homography (8 parameters) and a slight bend (12), blurred by an isotropic
// Gaussian and the pixel's square, times a gain that changes linearly over the tag, plus an offset.
// Each straight-sided quadrant of the pattern has its exact Gaussian integral (bivariate normal);
// beyond its second moment the pixel's square enters by its fourth cumulant along each edge's
// normal. Gauss-Newton, damped where it fails, with analytic derivatives, from a start within about
// half a cell. What the residuals then show is taken into account: uneven light and focus by one
// more step, noise that neighbours share by the covariance. Pixels at an end of the levels' range
// only bound the light. A lens bends a large tag beyond third order: in a tag longer than 110 px,
// or strongly bent, each corner is fitted by itself, from the 40 px of both sides next to it, with
// the shift of borders that the whole tag has. The corners are then uncorrelated. Throws Error for
// a pattern of another shape, or a camera of another size than the picture.
TagFit refine_tag(const ImageView8& image, const TagPattern& pattern,
                  const std::array<Eigen::Vector2d, 4>& start, const TagFitOptions& options = {});
TagFit refine_tag(const ImageView16& image, const TagPattern& pattern,
                  const std::array<Eigen::Vector2d, 4>& start, const TagFitOptions& options = {});

// Finds a corner of a checkerboard by fitting the pixels about it, up to 40 px on each side, with
// the same model. `image_from_pattern` is approximate: to a quarter of a square at the corner, to
// about 3 % in scale. Without a camera in the options the bends are estimated, which costs half as
// much again in standard deviation. Throws Error as refine_tag() does.
CornerFit refine_corner(const ImageView8& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern,
                        const TagFitOptions& options = {});
CornerFit refine_corner(const ImageView16& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern,
                        const TagFitOptions& options = {});

}  // namespace tagcal
