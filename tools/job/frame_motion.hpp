#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// A new look at the board: an eighth of a tag that is a tenth of the picture wide.
constexpr double kStepShare = 0.0125;  // of the image's diagonal

// The motion from one frame of a sequence to the next, of pictures of about 160 pixels.
class FrameMotion {
 public:
  struct Step {
    // The mean normal flow, |dI/dt| / |gradient|; 0 for the first frame, and where the size
    // changes.
    double moved_px = 0;   // of the frame as it is
    double sharpness = 0;  // sum of the gradient's components: for comparison with its neighbours
  };
  Step take(const Image8& frame);

 private:
  Image8 before_;
};

// The frames of a video or bag of `num_frames` that are worth a search for the board: one for each
// step by which the picture moves, the sharpest of those between two steps; up to kFewestWalked
// frames all of them; of more than kMostWalked as many, evenly. Decodes each frame once. A frame
// that cannot be read is passed over.
constexpr std::size_t kFewestWalked = 300;
constexpr std::size_t kMostWalked = 1000;  // a limit of work: minutes of detection
std::vector<std::size_t> walked_frames(const std::filesystem::path& sequence,
                                       std::size_t num_frames);

}  // namespace tagcal::tools
