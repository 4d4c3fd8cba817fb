#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// Basalt's calibration.json (cereal's value0): intrinsics, resolution and T_imu_cam of each camera.

namespace tagcal::internal {

bool has_basalt_keys(const YamlValue& top);
CameraFile read_basalt(const YamlValue& top);
FormatOutput write_basalt(const CameraFile& file);

}  // namespace tagcal::internal
