#pragma once

#include "tagcal/io/formats/colmap_format.hpp"

// COLMAP's rig_config.json, which `colmap rig_configurator` reads (3.12 and later): cameras by the
// folders of their pictures, their places and lenses, without the sizes of the pictures.

namespace tagcal::internal {

bool is_rig_config(std::string_view text);
CameraFile read_rig_config(const std::string& text, const std::string& name);

// Precondition: colmap_rig(file) has a value.
std::string rig_config_text(const CameraFile& file);
FormatOutput write_rig_config(const CameraFile& file);

// A sentence if the frame of the rig is another one in COLMAP.
void note_reference(const CameraFile& file, const ColmapRig& rig, std::vector<std::string>& notes);

}  // namespace tagcal::internal
