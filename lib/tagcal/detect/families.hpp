#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// Names of the supported tag families.
std::vector<std::string> tag_family_names();

// Names of OpenCV's predefined dictionaries of markers, each a family too: "DICT_4X4_50", ..,
// "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_36h11".
std::vector<std::string> tag_dictionary_names();

// The codes and layout of a family or dictionary with a black border `border_bits` cells wide: 1 as
// generated, 2 as on Kalibr's boards (only for families whose border surrounds their bits). Throws
// Error for an unknown family or a border that it cannot have.
TagFamily tag_family(std::string_view name, int border_bits);

// The families of all tags on the boards, as render_light needs them. Throws Error as tag_family.
TagFamilies tag_families(const std::vector<PlacedBoard>& boards);

// Throws Error if the family of a board's tags lacks one of them, or cannot have the border or the
// corner squares of the board. Boards without tags have none to check.
void check_tags(const Board& board);

}  // namespace tagcal
