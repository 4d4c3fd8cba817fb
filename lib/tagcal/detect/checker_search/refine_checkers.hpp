#pragma once

#include "tagcal/detect/board_search/refine_corners.hpp"

// Private to detect.
namespace tagcal::internal {

// As refine_corners(), for the corners of checkerboards and ChArUco boards, which it leaves as they
// are. Here `num_tags` counts corners.
RefinedCorners refine_checkers(const std::vector<ImageSource>& images,
                               const std::vector<PlacedBoard>& boards,
                               const std::vector<View>& views, const Camera& camera,
                               int threads = 0);

}  // namespace tagcal::internal
