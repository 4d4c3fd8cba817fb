#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tagcal {

// The patterns of an AprilTag family, as plain data; tagcal/detect/families.hpp fills it from the
// AprilTag library. Cells are counted from the upper-left cell of the whole printed tag, x right,
// y down; total_width counts all cells, the white (or, for a reversed border, black) frame
// included.
struct TagFamily {
  struct Cell {
    int x = 0;
    int y = 0;
  };

  std::string name;
  int width_at_border = 0;  // cells between the corners that the detector reports
  int total_width = 0;      // cells of the whole pattern
  bool reversed_border = false;
  std::vector<Cell> bits;            // place of each bit relative to the border's upper-left cell
  std::vector<std::uint64_t> codes;  // per id, bits.front() is the most significant
};

}  // namespace tagcal
