#pragma once

#include <optional>
#include <string>

#include "draw/sheet.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::tools {

// A flat board (z = 0) as a page to print, true to scale, with a scale bar and a caption that says
// what it is; on a page of the given size, or as large as needed. `name` is that of its file.
PrintedSheet board_sheet(const Board& board, const TagFamilies& families, const std::string& name,
                         const std::optional<Paper>& page = {});

// "6 x 6 tags of 88 mm", "8 x 5 corners, squares of 30 mm": what a user measures.
std::string size_text(const Board& board);

// The least width of a part of one colour.
double least_cell_mm(const Board& board, const TagFamilies& families);

// A board of the same pattern that fills a sheet of paper, as it lies.
struct FittedBoard {
  Board board;
  Paper page;
};

// The largest board of this pattern on the paper, upright or lying (only lying if `landscape`): the
// size of its tags or squares is a multiple of half a millimetre; the other lengths keep their
// ratio to it, but markers are multiples of half a millimetre too. Throws Error if not even the
// smallest fits.
FittedBoard fitted_board(const Board& board, const TagFamilies& families, const std::string& name,
                         const Paper& paper, bool landscape);

}  // namespace tagcal::tools
