#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// sensor.yaml of the EuRoC data sets: one camera with Kalibr's lenses, and T_BS, its place on the
// body, which is the IMU.

namespace tagcal::internal {

bool has_euroc_keys(const YamlValue& top);
CameraFile read_euroc(const YamlValue& top);
FormatOutput write_euroc(const CameraFile& file);

}  // namespace tagcal::internal
