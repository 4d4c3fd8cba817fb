#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::internal {

// True if a file is a field layout of WPILib (AprilTagFieldLayout of the FIRST Robotics
// Competition): JSON with the lists `tags` and `field`, and no `target_type`.
bool is_field_layout(const YamlValue& top);

// The tags of a field layout, in the field's frame: x along the field, z up, metres. WPILib's tag
// frame has x out of the tag and z up. The file names neither the size of the tags nor their
// family: they are tag36h11 and, without `tag_size_m`, 0.1651 m; a warning says so. `first_id`, if
// given, replaces the smallest id, and shifts the others. Throws Error.
Board read_field_layout(const YamlValue& top, std::optional<int> first_id,
                        std::optional<double> tag_size_m, std::vector<std::string>* warnings);

}  // namespace tagcal::internal
