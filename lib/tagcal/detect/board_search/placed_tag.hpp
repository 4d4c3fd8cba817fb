#pragma once

#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// A tag in the plane of its panel, metres, and in the picture where it was found.
struct PlacedTag {
  int id = 0;
  Eigen::Vector2d centre;
  Quad corners;
  std::optional<Quad> seen;
  std::vector<int> tried_from;  // ids that predicted it in the last try
};

// A tag's corners in the plane of their panel.
Quad on_panel(const Tag& tag, const Pose& panel_from_board);

// Predicted place of a tag in the picture, by the homography of the first `count` of the seen tags
// `from`, nearest first; no value if the tag would be seen from behind or lie beyond the horizon.
std::optional<Quad> predicted(const PlacedTag& tag, const std::vector<const PlacedTag*>& from,
                              std::size_t count);

}  // namespace tagcal::internal
