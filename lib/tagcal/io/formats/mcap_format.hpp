#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

namespace tagcal::internal {

// A bag of messages of Foxglove's schemas in JSON, which Foxglove and rerun show
// (https://mcap.dev/spec, https://docs.foxglove.dev/docs/sdk/schemas). At the time of each pose:
//   /camera      foxglove.CameraCalibration, also without poses
//   /tf          foxglove.FrameTransform, the camera in the frame "world"
//   /findings    foxglove.Log, of the findings of the pose
// in one chunk with its index.
FormatOutput write_mcap(const CameraFile& file);

}  // namespace tagcal::internal
