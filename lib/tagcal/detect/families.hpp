#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/board.hpp"

namespace tagcal {

// The families known to the AprilTag library that this one supports.
std::vector<std::string> tag_family_names();

// The patterns of a family with a black border `border_bits` cells wide (1 as generated, 2 as on
// Kalibr's boards, which only the families with a border outside their bits can have). Throws
// Error, with the known names, for an unknown family or a border that it cannot have.
TagFamily tag_family(std::string_view name, int border_bits);

}  // namespace tagcal
