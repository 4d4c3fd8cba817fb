#pragma once

#include <optional>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

// The mistake of an AprilGrid or ChArUco board with more rows in the target file than the pictures
// show, although several of them have room for the next one. A few pictures of a ChArUco board are
// loaded again.
std::optional<TargetMistake> missing_rows(const std::vector<ImageSource>& images,
                                          const std::vector<DetectedPicture>& found,
                                          const Board& board);

}  // namespace tagcal::internal
