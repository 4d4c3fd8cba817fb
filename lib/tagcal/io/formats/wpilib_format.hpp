#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// The JSON of WPILib's WPIcal: camera_matrix (9 numbers) and distortion_coefficients (OpenCV's) of
// one camera, without the size of its pictures.

namespace tagcal::internal {

bool has_wpilib_keys(const YamlValue& top);
CameraFile read_wpilib(const YamlValue& top);
FormatOutput write_wpilib(const CameraFile& file);

}  // namespace tagcal::internal
