#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// Kalibr's camchain.yaml: cam0, cam1, .. and the transform of each from the one before it.

namespace tagcal::internal {

bool has_kalibr_keys(const YamlValue& top);
CameraFile read_kalibr(const YamlValue& top);
// One camera with the same keys and none of the names: sensor.yaml of the EuRoC data sets.
bool has_euroc_keys(const YamlValue& top);
CameraFile read_euroc(const YamlValue& top);
FormatOutput write_kalibr(const CameraFile& file);

}  // namespace tagcal::internal
