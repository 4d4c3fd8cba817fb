#pragma once

#include <pybind11/pybind11.h>

#include "tagcal/scene/board.hpp"

namespace tagcal::python {

// Board.grid, Board.checkerboard, ..: each kind of target by name.
void define_board_constructors(pybind11::class_<Board>& board);

// The kind of a board by the name of its constructor: "grid", "checkerboard", "charuco", "tags" or
// "points".
std::string board_kind(const Board& board);

// One line on a board, for people.
std::string board_text(const Board& board);

// The kind and the arguments of its constructor, as plain values; and the way back.
pybind11::dict board_to_dict(const Board& board);
Board board_from_dict(const pybind11::dict& fields);

}  // namespace tagcal::python
