#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/formats/lens_numbers.hpp"

// COLMAP's text: cameras.txt, and images.txt for poses.

namespace tagcal::internal {

// Returns true if the first line that is no comment begins as one of cameras.txt.
bool is_colmap_cameras(std::string_view text);

// `images`: the text of images.txt, if there is one. The names are those of the files in messages.
struct ColmapText {
  std::string name;
  std::string text;
};
// `rigs`: that of rigs.txt (COLMAP 3.12 and later), which places the cameras.
CameraFile read_colmap(const ColmapText& cameras, const std::optional<ColmapText>& images,
                       const std::optional<ColmapText>& rigs = {});

// cameras.txt, images.txt and an empty points3D.txt, or cameras.txt only; of a rig also rigs.txt,
// frames.txt and rig_config.json.
FormatOutput write_colmap(const CameraFile& file, bool cameras_only);

}  // namespace tagcal::internal
