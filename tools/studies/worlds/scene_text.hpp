#pragma once

#include <string>

#include "tagcal/scene/scene.hpp"

namespace tagcal {

// A scene with explicit poses, of grids or tags, as a file for `tagcal render`
// (docs/reference/formats.md). Read back, it is the same to the last bit.
std::string scene_text(const Scene& scene);

}  // namespace tagcal
