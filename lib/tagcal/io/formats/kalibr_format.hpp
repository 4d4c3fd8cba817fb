#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// Kalibr's camchain.yaml: cam0, cam1, .. and the transform of each from the one before it.

namespace tagcal::internal {

CameraFile read_kalibr(const YamlValue& top);
// One camera with the same keys and none of the names: sensor.yaml of the EuRoC data sets.
CameraFile read_euroc(const YamlValue& top);
FormatOutput write_kalibr(const CameraFile& file);

}  // namespace tagcal::internal
