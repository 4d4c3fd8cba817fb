#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tagcal/scene/moving_scene.hpp"

namespace tagcal {

// A scene recipe (docs/reference/formats.md): camera, frames, boards, occluders, path, sensor.
// Angles in the file are degrees (keys end in _deg). Throws Error: unknown or missing keys, wrong
// types, values out of range. Unknown keys in the aprilgrid files of its boards go to `warnings`
// (may be null).
MovingScene read_moving_scene(const std::filesystem::path& file,
                              std::vector<std::string>* warnings = nullptr);

// The same for a scene in which nothing moves but the camera, whose path is in the world; throws
// Error for others.
Scene read_scene(const std::filesystem::path& file, std::vector<std::string>* warnings = nullptr);

}  // namespace tagcal
