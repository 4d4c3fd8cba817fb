#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Private to detect: the markers of OpenCV's aruco module.
namespace tagcal::internal {

struct MarkerDictionary {
  int side = 0;          // bits along a side, without the border
  int min_distance = 0;  // least number of bits in which two markers differ, turned or not
  // By id: the bits of the upright marker as OpenCV draws it, row by row, the upper left one the
  // most significant; 1 is white.
  std::vector<std::uint64_t> codes;
};

// Names of the predefined dictionaries, as OpenCV calls them: "DICT_4X4_50", ...
std::vector<std::string> marker_dictionary_names();

// No value if OpenCV has no dictionary of this name.
std::optional<MarkerDictionary> marker_dictionary(std::string_view name);

}  // namespace tagcal::internal
