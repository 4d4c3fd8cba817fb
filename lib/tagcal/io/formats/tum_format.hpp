#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

namespace tagcal::internal {

// Poses as a trajectory of the TUM data sets: `timestamp tx ty tz qx qy qz qw`, world from camera.
FormatOutput write_tum(const CameraFile& file);

}  // namespace tagcal::internal
