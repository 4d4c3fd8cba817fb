#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace tagcal::tools {

// The frames of a video or bag of `num_frames` that are worth a search for the board: one for each
// step by which the picture moves, the sharpest of those between two steps; up to kFewestWalked
// frames all of them; of more than kMostWalked as many, evenly. Decodes each frame once. A frame
// that cannot be read is passed over.
constexpr std::size_t kFewestWalked = 300;
constexpr std::size_t kMostWalked = 1000;  // a limit of work: minutes of detection
std::vector<std::size_t> walked_frames(const std::filesystem::path& sequence,
                                       std::size_t num_frames);

}  // namespace tagcal::tools
