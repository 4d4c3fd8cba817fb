#pragma once

#include <map>
#include <optional>

#include "page_data/json_values.hpp"
#include "page_data/page_content.hpp"

namespace tagcal::tools {

// Points of the boards in the world, of bent boards if there is a bend.
std::map<CornerId, Eigen::Vector3d> bent_points_in_world(const std::vector<PlacedBoard>& boards,
                                                         const std::optional<BoardWarp>& warp);

// Boards for the view in 3D: outline, tags or dark squares, points.
PageJson boards_json(const std::vector<PlacedBoard>& boards);

// The estimated bend as heights over the board; null without one.
PageJson warp_json(const std::vector<PlacedBoard>& boards, const std::optional<BoardWarp>& warp);

// The next view, with the largest board projected into the image; null without one.
PageJson advice_json(const PageContent& content);

}  // namespace tagcal::tools
