#pragma once

#include "tagcal/io/types.hpp"

// The rectification of a stereo pair, as files of other programs have it beside the cameras.

namespace tagcal::internal {

// Sets that of two placed cameras, whose rectified pictures have pixels of both cameras only
// (`alpha` 0, as ROS' calibrator). Where the pair has none (rectify.hpp), a note says why.
void set_rectification(CameraFile& file);

}  // namespace tagcal::internal
