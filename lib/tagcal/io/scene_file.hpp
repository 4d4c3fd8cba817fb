#pragma once

#include <filesystem>

#include "tagcal/scene/scene.hpp"

namespace tagcal {

// A scene recipe (docs/formats.md): camera, boards, occluders, path, sensor. Angles in the file are
// degrees (keys end in _deg). Throws Error: unknown or missing keys, wrong types, values out of
// range.
Scene read_scene(const std::filesystem::path& file);

}  // namespace tagcal
