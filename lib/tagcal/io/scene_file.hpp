#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/rig_scene.hpp"

namespace tagcal {

// A scene recipe (docs/reference/formats.md): camera, frames, boards, occluders, path, sensor; or a
// rig in place of the camera. Angles in the file are degrees (keys end in _deg). Throws Error:
// unknown or missing keys, wrong types, values out of range. Unknown keys in the aprilgrid files of
// its boards go to `warnings` (may be null).
using AnyScene = std::variant<MovingScene, RigScene>;
AnyScene read_any_scene(const std::filesystem::path& file,
                        std::vector<std::string>* warnings = nullptr);

// The same for a scene with one camera; throws Error for a rig.
MovingScene read_moving_scene(const std::filesystem::path& file,
                              std::vector<std::string>* warnings = nullptr);

// The same for a scene in which nothing moves but the camera, whose path is in the world; throws
// Error for others.
Scene read_scene(const std::filesystem::path& file, std::vector<std::string>* warnings = nullptr);

// The largest numbers that a scene may have (docs/reference/limits.md), for programs that make one.
struct SceneLimits {
  int views;
  std::size_t vignetting_terms;
  std::int64_t pixels;  // of a picture
  std::size_t polygon_corners;
};
SceneLimits scene_limits();

// Why corners are no occluder, a flat convex polygon, as the end of a sentence ("must not lie on a
// line"). No value if they are one. `corners`: three or more, finite.
std::optional<std::string> occluder_defect(std::span<const Eigen::Vector3d> corners);

}  // namespace tagcal
