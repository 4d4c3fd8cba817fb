#pragma once

#include <string>

#include "draw/paper.hpp"
#include "draw/sheet.hpp"

namespace tagcal::tools {

// A PDF of one page, true to scale.
std::string sheet_pdf(const Sheet& sheet, const std::string& title);

// A page larger than the paper, cut into several that overlap.
struct Tiling {
  Paper paper;  // as it lies
  int columns = 0;
  int rows = 0;
};

// The tiling with the fewest pages, in portrait or landscape.
Tiling tiling_of(const Sheet& sheet, const Paper& paper);

// A PDF with a page for each tile, row by row from above, with marks where to cut and join.
std::string tiled_pdf(const Sheet& sheet, const Tiling& tiling, const std::string& title);

}  // namespace tagcal::tools
