#pragma once

#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/refine_edges.hpp"

// Private to detect.
namespace tagcal::internal {

// A tag in the plane of its panel, metres, and in the picture where it was found.
struct PlacedTag {
  int id = 0;
  Eigen::Vector2d centre;
  Quad corners;
  std::optional<Quad> seen;
  std::vector<int> tried_from;  // the neighbours of the last try
};

// Where a tag should be in the picture, by the homography of the first `count` of the seen tags
// `from`, nearest first; no value where that shows it from behind, or beyond the horizon.
std::optional<Quad> predicted(const PlacedTag& tag, const std::vector<const PlacedTag*>& from,
                              std::size_t count);

}  // namespace tagcal::internal
