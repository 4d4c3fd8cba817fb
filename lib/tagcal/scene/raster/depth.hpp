#pragma once

#include <span>

#include "tagcal/scene/image.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::internal {

// The depth z of the first of some sheets that the ray through the centre of each pixel meets; NaN
// for none.
ImageF depth_of_sheets(const Shadows& shadows, std::span<const std::size_t> sheets,
                       const Camera& camera);

}  // namespace tagcal::internal
