#pragma once

#include <array>
#include <map>
#include <string>

#include "tagcal/scene/render.hpp"

// Pictures of a board of 6 x 6 tags. Private to study.

namespace tagcal::study {

using TagCorners = std::array<Eigen::Vector2d, 4>;

// The board fills most of the picture of a camera with barrel distortion; blur 0.8 px, noise of 3
// grey levels.
struct BoardScene {
  Scene scene;
  TagFamilies families;

  // Plain tags with a border of one bit, or Kalibr's with black squares and two bits.
  BoardScene(const ImageSize& size, bool is_plain);

  const PlacedBoard& board() const { return scene.boards.front(); }

  // The true corners of the tags that are wholly in the picture.
  std::map<int, TagCorners> whole_tags(const Pose& camera_from_world) const;
};

// The board 0.95 m ahead, `aside_m` off the optical axis, tilted by half a radian about an axis.
Pose board_pose(const Eigen::Vector3d& tilt_axis, double aside_m);

}  // namespace tagcal::study
