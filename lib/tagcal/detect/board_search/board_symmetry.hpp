#pragma once

#include <string>
#include <vector>

#include "tagcal/scene/dataset.hpp"

// Private to detect: boards that look the same after a turn.
namespace tagcal::internal {

// "the symmetric grid of 8 x 6 circles"
std::string name_of(const CircleGrid& grid);

// One sentence for each checkerboard or grid of circles that looks the same if it is turned.
std::vector<std::string> symmetry_warnings(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal::internal
