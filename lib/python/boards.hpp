#pragma once

#include <pybind11/pybind11.h>

#include <span>
#include <vector>

#include "python/arrays.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::python {

// A target: a Board, a PlacedBoard, or a list of these.
using TargetLike = Argument<"TargetLike">;

// The boards of a target; a Board alone stands at the world's origin. Throws Error with the
// argument's name for other objects, an empty list, and ids that two boards share.
std::vector<PlacedBoard> boards_of(const TargetLike& target, const char* name);

// (N, 2), tag and corner.
py::array_t<int> array_of_ids(std::span<const CornerId> ids);

// The class View; a part of bind_boards.
void bind_view(py::module_& m);

// Adds the keys of a substrate without those that have their defaults, as in files of targets.
void add_substrate(const Substrate& substrate, py::dict& fields);

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
