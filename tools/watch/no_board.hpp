#pragma once

#include <string>
#include <vector>

#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// Why a picture shows no board, in a few words. Costs about ten times as much as detection.
std::string why_no_board(const ImageView8& image, const std::vector<PlacedBoard>& boards);

}  // namespace tagcal::tools
