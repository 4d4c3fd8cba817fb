#pragma once

#include <array>

#include "tagcal/reproject/rectify.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// Both rectified pictures of one instant side by side (one above the other, if the pair is
// vertical), with lines across both, on which a point lies in both. Every n-th pixel, so that the
// sheet is about `longest_px` wide at most. Throws Error if a picture is not of its camera's size.
ImageRgb rectified_sheet(const KnownRig& rig, const RectifiedPair& pair,
                         const std::array<Image8, 2>& pictures, int longest_px);

}  // namespace tagcal::tools
