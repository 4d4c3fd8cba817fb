#pragma once

#include <optional>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

// The mistake of a picture that shows nothing of the boards, but a board of another type: tags,
// markers of a ChArUco board, or a checkerboard.
std::optional<TargetMistake> target_type_mistake(const ImageView8& image,
                                                 const std::vector<PlacedBoard>& boards);

}  // namespace tagcal::internal
