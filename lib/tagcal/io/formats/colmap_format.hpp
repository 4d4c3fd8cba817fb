#pragma once

#include <filesystem>
#include <optional>

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
CameraFile read_colmap(const ColmapText& cameras, const std::optional<ColmapText>& images);

// cameras.txt, images.txt and an empty points3D.txt, or cameras.txt only.
FormatOutput write_colmap(const CameraFile& file, bool cameras_only);

}  // namespace tagcal::internal
