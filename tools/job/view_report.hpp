#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal::tools {

// The other end of a line that begins at the followed point.
struct LineEnd {
  NamedPoint point;
  FollowedPoint followed;
};

// One camera of a scene, its matrices, and a point followed through them.
struct ViewReport {
  const Scene& scene;
  std::string image;  // name of the view
  ViewingPipeline pipeline;
  NamedPoint point;
  FollowedPoint followed;
  Frames<Affine> frames;                 // the scene's hierarchy
  const std::vector<HungBoard>& boards;  // on it
  std::optional<LineEnd> line_to = std::nullopt;
};

// If the point is seen, and else why not.
std::string sight_line(const FollowedPoint& followed);

// The planes of the view volume that a point is beyond: "far", "left and bottom"; "" inside.
std::string planes_beyond(const ViewReport& report);

// A fisheye has no view volume: a sentence on the pinhole to which the volume belongs; "" for other
// lenses.
std::string pinhole_note(const ViewReport& report);

// A frame of the scene or a board, and its transforms.
struct ShownFrame {
  std::string name;
  std::optional<std::size_t> parent;  // index in the list; none: the world
  std::optional<std::size_t> board;   // set for a board
  Affine parent_from_frame;
  Affine world_from_frame;
  Affine frame_from_world;
};

// All frames and boards below the world, each behind its parent.
std::vector<ShownFrame> shown_frames(const ViewReport& report);

// The same on the way from the world to a board.
std::vector<ShownFrame> frames_of_board(const ViewReport& report, std::size_t board);

}  // namespace tagcal::tools
