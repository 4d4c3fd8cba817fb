#pragma once

#include <map>
#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// The name of the only mistake of a ChArUco board with which all corners are found.
inline constexpr const char* kWrongMarkerSize = "wrong marker size";

using SeenQuads = std::map<int, Quad>;  // tags of a picture by id

// The tags of a view's corners; those with fewer than four corners are left out.
SeenQuads quads_of(const View& view);

// Compares the places of the tags relative to their neighbours in a picture with the target file:
// an AprilGrid's columns and spacing; a ChArUco board's squares, pattern and size of markers. Other
// boards, and pictures with few tags, show no mistake.
std::vector<TargetMistake> layout_mistakes(const Board& board, const SeenQuads& seen);

}  // namespace tagcal::internal
