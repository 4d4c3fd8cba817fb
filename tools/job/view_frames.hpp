#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/view_report.hpp"

namespace tagcal::tools {

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
