#pragma once

#include <string>
#include <string_view>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/rig_scene.hpp"

// Private to io: the rig of a scene, in place of its camera (docs/reference/formats.md).

namespace tagcal::internal {

// Reads `rig` and the sensors of its cameras into a scene whose own sensor has not been read.
void read_rig(const YamlValue& top, RigScene& scene);

}  // namespace tagcal::internal
