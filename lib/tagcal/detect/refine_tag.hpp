#pragma once

#include <Eigen/Core>
#include <array>

#include "tagcal/detect/types.hpp"

namespace tagcal {

// The pattern of a tag. The family's border may have any width: it is set to `border_bits`. Throws
// Error where the id is not in the family, or the family cannot have the border or the squares.
TagPattern tag_pattern(const TagFamily& family, int id, int border_bits,
                       const TagSurroundings& surroundings = {});

// Finds the corners of a tag whose pattern is known by fitting all of its pixels: grey level = the
// pattern under a homography (8 parameters) and a slight bend (12), blurred by an isotropic
// Gaussian and the pixel's square, times a gain that changes linearly over the tag, plus an offset.
// Each straight-sided quadrant of the pattern has its exact Gaussian integral (bivariate normal);
// the square beyond its second moment enters by the fourth cumulant along each edge's normal.
// Gauss-Newton with analytic derivatives, from corners that must lie within about half a cell.
// Lenses bend a large tag beyond third order: of one longer than 110 px, or found to be strongly
// bent, each corner is fitted by itself from the 40 px of both sides that are next to it; then
// corners of one tag are not correlated.
TagFit refine_tag(const Image8& image, const TagPattern& pattern,
                  const std::array<Eigen::Vector2d, 4>& start, const TagFitOptions& options = {});
TagFit refine_tag(const Image16& image, const TagPattern& pattern,
                  const std::array<Eigen::Vector2d, 4>& start, const TagFitOptions& options = {});

}  // namespace tagcal
