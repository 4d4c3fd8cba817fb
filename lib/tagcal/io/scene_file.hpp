#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tagcal/scene/scene.hpp"

namespace tagcal {

// A scene recipe (docs/formats.md): camera, boards, occluders, path, sensor. Angles in the file are
// degrees (keys end in _deg). Throws Error: unknown or missing keys, wrong types, values out of
// range. Unknown keys in the aprilgrid files of its boards go to `warnings` (may be null).
Scene read_scene(const std::filesystem::path& file, std::vector<std::string>* warnings = nullptr);

}  // namespace tagcal
