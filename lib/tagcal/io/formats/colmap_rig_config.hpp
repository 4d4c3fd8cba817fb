#pragma once

#include <string>
#include <string_view>

#include "tagcal/io/formats/colmap_rig.hpp"

// COLMAP's rig_config.json, which `colmap rig_configurator` reads (3.12 and later): cameras by the
// folders of their pictures, their places and lenses, without the sizes of the pictures.

namespace tagcal::internal {

bool is_rig_config(std::string_view text);
CameraFile read_rig_config(const std::string& text, const std::string& name);

std::string rig_config_text(const CameraFile& file, const ColmapRig& rig);
FormatOutput write_rig_config(const CameraFile& file);

}  // namespace tagcal::internal
