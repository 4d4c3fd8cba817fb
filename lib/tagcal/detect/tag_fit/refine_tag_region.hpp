#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/refine_tag_model.hpp"

// Private to detect: which part of a tag is fitted at once.
namespace tagcal::internal {

using TagCorners = std::array<Eigen::Vector2d, 4>;

// Its places on the tag are counted in units of about `scale`, from its middle or from its corner:
// then the homography has no entry that is large beside the others, and single precision will do.
struct TagRegion {
  TagGrid grid;
  TagCorners corners_on_tag;
  Eigen::Vector2d middle;             // about which bends are counted, px
  double scale = 1;                   // half of the region's side, px
  std::optional<std::size_t> corner;  // the only one that it is about; else all
};

double mean_half_side(const TagCorners& corners);

// The tag and what is around it, as far as that speaks of the corners.
TagRegion whole_tag(const TagPattern& pattern, const TagCorners& corners);

// The part around one corner of a large tag: where a lens bends strongly, what is farther says
// little of it that can be trusted.
TagRegion part_of_tag(const TagPattern& pattern, const TagCorners& corners, std::size_t corner);

}  // namespace tagcal::internal
