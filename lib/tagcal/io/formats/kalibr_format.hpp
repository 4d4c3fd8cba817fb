#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// Kalibr's camchain.yaml: cam0, cam1, .. and the transform of each from the one before it.

namespace tagcal::internal {

bool has_kalibr_keys(const YamlValue& top);
CameraFile read_kalibr(const YamlValue& top);
FormatOutput write_kalibr(const CameraFile& file);

}  // namespace tagcal::internal
