#pragma once

#include <string>
#include <string_view>

#include "tagcal/io/formats/lens_numbers.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// The keys of one camera that Kalibr and EuRoC share: resolution, camera_model, intrinsics,
// distortion_model, and coefficients under a key of each.

namespace tagcal::internal {

FileCamera read_kalibr_camera(const YamlValue& camera, std::string_view coefficients_key);

// Of a lens: its keys in Kalibr's words. Throws Error for one that Kalibr does not have.
struct KalibrLens {
  std::string_view camera_model;
  std::string intrinsics;
  std::string_view distortion_model;  // radtan, equidistant, none
  std::string distortion;
};
KalibrLens kalibr_lens(const FileCamera& camera, std::string_view format);

}  // namespace tagcal::internal
