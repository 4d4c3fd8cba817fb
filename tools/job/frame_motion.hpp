#pragma once

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

}  // namespace tagcal::tools
