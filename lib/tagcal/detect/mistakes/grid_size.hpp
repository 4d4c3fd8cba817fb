#pragma once

#include <optional>

#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

// The mistake in a checkerboard's numbers of corners, if the picture shows a grid of another size.
std::optional<TargetMistake> grid_size_mistake(const SeenChecker& seen, const Board& board);

}  // namespace tagcal::internal
