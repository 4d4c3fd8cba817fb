#pragma once

#include "tagcal/detect/board_search/refine_corners.hpp"

// Private to detect.
namespace tagcal::internal {

// As refine_corners(), for the centres of circles, which it leaves as they are. Here `num_tags`
// counts centres.
RefinedCorners refine_circles(const std::vector<ImageSource>& images,
                              const std::vector<PlacedBoard>& boards,
                              const std::vector<View>& views, const Camera& camera,
                              int threads = 0);

}  // namespace tagcal::internal
