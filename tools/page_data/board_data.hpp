#pragma once

#include <map>
#include <optional>

#include "page_data/json_values.hpp"
#include "page_data/page_content.hpp"

namespace tagcal::tools {

// Points of the boards in the world; of the one flat board as BoardWarp places them, if there is
// one.
std::map<CornerId, Eigen::Vector3d> bent_points_in_world(const std::vector<PlacedBoard>& boards,
                                                         const std::optional<BoardWarp>& warp);

// Boards for the view in 3D: outline, tags or dark squares, points.
PageJson boards_json(const std::vector<PlacedBoard>& boards);

// The terms of the board, and the heights over it; null without them.
PageJson warp_json(const std::vector<PlacedBoard>& boards, const std::optional<BoardWarp>& warp);

// The next view, with the largest board projected into the image; null without one.
PageJson advice_json(const PageContent& content);

}  // namespace tagcal::tools
