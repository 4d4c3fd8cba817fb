#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/tag_model.hpp"

// Private to detect: the part of a tag that is fitted at once.
namespace tagcal::internal {

using TagCorners = std::array<Eigen::Vector2d, 4>;

// Places on the tag are counted in units of about `scale`, from the region's middle or corner: the
// entries of the homography then have similar sizes, as single precision needs.
struct TagRegion {
  TagGrid grid;
  TagCorners corners_on_tag;
  Eigen::Vector2d middle;             // origin of the bends, px
  double scale = 1;                   // half of the region's side, px
  std::optional<std::size_t> corner;  // the region's only corner; empty: all four
};

double mean_half_side(const TagCorners& corners);

// The tag and its surroundings, as far as they help to locate the corners.
TagRegion whole_tag(const TagPattern& pattern, const TagCorners& corners);

// The part around one corner of a large tag. Under a strongly bending lens more distant pixels
// would bias the corner.
TagRegion part_of_tag(const TagPattern& pattern, const TagCorners& corners, std::size_t corner);

// The part around a corner of a checkerboard, which is the first of the region's four.
struct CornerRegion {
  TagRegion region;
  TagCorners start;
};
CornerRegion about_corner(const CornerPattern& pattern, const Eigen::Matrix3d& image_from_pattern);

}  // namespace tagcal::internal
