#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "tagcal/camera/lens.hpp"
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

// The seen tags nearest to another one, nearest first: of those that predict it.
std::vector<const PlacedTag*> nearest_tags(const PlacedTag& tag,
                                           const std::vector<const PlacedTag*>& seen);

// Tags in the order of their distances from found ones.
std::vector<PlacedTag*> nearest_first(std::vector<std::pair<double, PlacedTag*>> by_distance);

// The image of a panel's plane about a tag: the homography from the plane to pixels or, if a lens
// is known, to its rays. The lens must outlive it.
class PlaneView {
 public:
  // By the first `count` of the seen tags `from`, nearest first. No value if they do not determine
  // it, or are outside the lens' domain.
  static std::optional<PlaneView> about(const PlacedTag& tag,
                                        const std::vector<const PlacedTag*>& from,
                                        std::size_t count, const Lens* lens = nullptr);

  // No value beyond the horizon, or outside the lens' domain.
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& on_panel) const;
  std::optional<Eigen::Vector2d> on_plane(const Eigen::Vector2d& pixel) const;

 private:
  Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;

  Eigen::Matrix3d rays_from_plane_;
  const Lens* lens_ = nullptr;
  Eigen::Vector2d origin_, middle_;  // on the panel, and in the picture
  double scale_ = 1, per_px_ = 1;
};

// Predicted place of a tag in the picture; no value if the tag would be seen from behind or lie
// beyond the horizon.
std::optional<Quad> predicted(const PlacedTag& tag, const std::vector<const PlacedTag*>& from,
                              std::size_t count, const Lens* lens = nullptr);

}  // namespace tagcal::internal
