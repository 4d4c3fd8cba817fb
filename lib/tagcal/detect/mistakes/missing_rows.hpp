#pragma once

#include <optional>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// The mistake of an AprilGrid with more rows in the target file than any picture shows, although
// several pictures have room for the next one.
std::optional<TargetMistake> missing_rows(const std::vector<DetectedPicture>& found,
                                          const Board& board);

}  // namespace tagcal::internal
