#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Checks for corners that no picture can show.

namespace tagcal::internal {

// Most tags of the view turn the wrong way, as if they were seen from behind. False for corners
// that belong to no tag.
bool is_mirrored(std::span<const CornerId> ids, std::span<const Correspondence> correspondences);

std::size_t num_outside(std::span<const Correspondence> correspondences, const ImageSize& size);

// A warning if more corners lie outside of the image than noise and outliers put there.
std::optional<Finding> corners_outside(std::size_t num_outside, std::size_t num_corners,
                                       const ImageSize& size);

// Gives the refusal the sentence for points that fit in their mirror image only: their axes are
// left-handed, or a coordinate has the wrong sign.
void say_mirror_image_fits(std::vector<Finding>& findings);

}  // namespace tagcal::internal
