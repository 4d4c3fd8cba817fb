#include "python/boards.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <variant>

#include "python/arrays.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/overloaded.hpp"

namespace tagcal::python {
using namespace py::literals;
namespace {

// Throws Error if the family lacks a tag or cannot have the border, and for positions beyond
// double.
Board checked(Board board) {
  check_tags(board);
  for (const TargetPoint& point : target_points(board))
    if (!point.position.allFinite()) throw Error("board: its sizes are too large");
  return board;
}

Board grid(int columns, int rows, double tag_size, double tag_spacing, const std::string& family,
           int border_bits, std::optional<bool> corner_squares, int first_id) {
  return checked(make_board(AprilGrid{columns, rows, tag_size, tag_spacing, first_id, family,
                                      border_bits, corner_squares.value_or(border_bits == 2)}));
}

Board checkerboard(int columns, int rows, double spacing, std::optional<double> row_spacing,
                   bool starts_black, int first_id) {
  return checked(make_board(
      Checkerboard{columns, rows, spacing, row_spacing.value_or(spacing), starts_black, first_id}));
}

Board charuco(int square_columns, int square_rows, double square_size, double marker_size,
              const std::string& dictionary, bool legacy, int first_id, int first_marker_id) {
  if (square_columns < 3 || square_rows < 3)
    throw Error("board: must have 3 x 3 squares or more, got " + std::to_string(square_columns) +
                " x " + std::to_string(square_rows));
  return checked(make_board(Charuco{square_columns, square_rows, square_size, marker_size,
                                    dictionary, legacy, first_id, first_marker_id}));
}

Board circle_grid(int columns, int rows, double spacing, double diameter, bool asymmetric,
                  int first_id) {
  return checked(make_board(CircleGrid{columns, rows, spacing, diameter, asymmetric, first_id}));
}

// (N,) different whole numbers >= 0.
std::vector<int> different_ids(const ArrayLike& argument, const char* name) {
  const py::array_t<double> array = real_array(argument, name);
  if (array.ndim() != 1 || array.size() == 0 || array.size() > kMaxBoardParts)
    throw Error(std::string(name) + ": must have the shape (N,), with 1 to " +
                std::to_string(kMaxBoardParts) + " ids");
  constexpr double kLargest = 1 << 30;  // numeric: fits an int
  std::vector<int> ids;
  std::set<int> seen;
  for (py::ssize_t i = 0; i < array.size(); ++i) {
    const double id = array.data()[i];
    if (!(id >= 0 && id <= kLargest && id == std::floor(id)))
      throw Error(std::string(name) + ": must be whole numbers >= 0, got " + number(id, 17));
    ids.push_back(static_cast<int>(id));
    if (!seen.insert(ids.back()).second)
      throw Error(std::string(name) + ": " + number(id, 17) + " occurs twice");
  }
  return ids;
}

// One size for all tags, or one for each.
std::vector<double> tag_sizes(const ArrayLike& argument, std::size_t n) {
  const py::array_t<double> array = real_array(argument, "size");
  const bool is_one = array.ndim() == 0;
  if (!is_one && !(array.ndim() == 1 && array.shape(0) == static_cast<py::ssize_t>(n)))
    throw Error("size: must be a number, or have the shape (" + std::to_string(n) + ",)");
  std::vector<double> sizes(n);
  for (std::size_t i = 0; i < n; ++i) sizes[i] = positive(array.data()[is_one ? 0 : i], "size");
  return sizes;
}

Board tags(const ArrayLike& ids, const ArrayLike& size, const PosesLike& board_from_tags,
           const std::string& family, int border_bits) {
  const std::vector<int> numbers = different_ids(ids, "ids");
  const std::vector<double> sizes = tag_sizes(size, numbers.size());
  const std::vector<Pose> poses = poses_of(board_from_tags, "board_from_tags");
  check_same_length(numbers.size(), "ids", poses.size(), "board_from_tags");
  Tags board{family, border_bits, {}};
  for (std::size_t i = 0; i < numbers.size(); ++i)
    board.tags.push_back({numbers[i], sizes[i], poses[i]});
  return checked({std::move(board), {}});
}

Board one_tag(double size, int id, const std::string& family, int border_bits) {
  positive(size, "size");
  if (id < 0) throw Error("id: must be >= 0, got " + std::to_string(id));
  return checked({Tags{family, border_bits, {{id, size, Pose()}}}, {}});
}

Board points(const ArrayLike& positions, const std::optional<ArrayLike>& ids) {
  const Rows3 rows(positions, "positions");
  if (rows.size() == 0 || rows.size() > static_cast<std::size_t>(kMaxBoardParts))
    throw Error("positions: must have 1 to " + std::to_string(kMaxBoardParts) + " rows, got " +
                std::to_string(rows.size()));
  std::vector<int> numbers(rows.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<int>(i);
  if (ids) numbers = different_ids(*ids, "ids");
  check_same_length(rows.size(), "positions", numbers.size(), "ids");
  Points board;
  for (std::size_t i = 0; i < rows.size(); ++i) board.points.push_back({{numbers[i], 0}, rows[i]});
  return {std::move(board), {}};
}

// The arguments of each kind's constructor.
py::dict arguments_of(const Tags& board) {
  py::list ids, sizes, poses;
  for (const Tag& tag : board.tags) {
    ids.append(tag.id);
    sizes.append(tag.size);
    poses.append(py::cast(tag.board_from_tag).attr("to_dict")());
  }
  return py::dict("ids"_a = ids, "size"_a = sizes, "board_from_tags"_a = poses,
                  "family"_a = board.family, "border_bits"_a = board.border_bits);
}

py::dict arguments_of(const Points& board) {
  py::list ids, positions;
  for (const TargetPoint& point : board.points) {
    ids.append(point.id.tag_id);
    positions.append(std::vector(point.position.data(), point.position.data() + 3));
  }
  return py::dict("positions"_a = positions, "ids"_a = ids);
}

py::dict arguments_of(const AprilGrid& grid) {
  return py::dict("columns"_a = grid.columns, "rows"_a = grid.rows, "tag_size"_a = grid.tag_size,
                  "tag_spacing"_a = grid.tag_spacing, "family"_a = grid.family,
                  "border_bits"_a = grid.border_bits, "corner_squares"_a = grid.corner_squares,
                  "first_id"_a = grid.first_id);
}

py::dict arguments_of(const Charuco& board) {
  return py::dict("square_columns"_a = board.square_columns, "square_rows"_a = board.square_rows,
                  "square_size"_a = board.square_size, "marker_size"_a = board.marker_size,
                  "dictionary"_a = board.dictionary, "legacy"_a = board.legacy,
                  "first_id"_a = board.first_id, "first_marker_id"_a = board.first_marker_id);
}

py::dict arguments_of(const Checkerboard& board) {
  return py::dict("columns"_a = board.columns, "rows"_a = board.rows,
                  "spacing"_a = board.column_spacing, "row_spacing"_a = board.row_spacing,
                  "starts_black"_a = board.starts_black, "first_id"_a = board.first_id);
}

py::dict arguments_of(const CircleGrid& grid) {
  return py::dict("columns"_a = grid.columns, "rows"_a = grid.rows, "spacing"_a = grid.spacing,
                  "diameter"_a = grid.diameter, "asymmetric"_a = grid.asymmetric,
                  "first_id"_a = grid.first_id);
}

std::string times(int columns, int rows) {
  return std::to_string(columns) + " x " + std::to_string(rows);
}

// By the index of a board's pattern.
constexpr const char* kKinds[] = {"points",       "tags",    "grid",
                                  "checkerboard", "charuco", "circle_grid"};
static_assert(std::size(kKinds) == std::variant_size_v<BoardPattern>);

}  // namespace

std::string board_kind(const Board& board) { return kKinds[board.pattern.index()]; }

std::string board_text(const Board& board) {
  const auto print = [](const auto& tags) {
    return tags.family + ", border of " + std::to_string(tags.border_bits) +
           (tags.border_bits == 1 ? " bit" : " bits");
  };
  const auto apart = [](double spacing) { return ", " + number(spacing) + " m apart"; };
  return std::visit(
      internal::Overloaded{
          [](const Points& measured) { return std::to_string(measured.points.size()) + " points"; },
          [&](const Tags& single) {
            const std::vector<Tag>& tags = single.tags;
            if (tags.size() != 1) return std::to_string(tags.size()) + " tags of " + print(single);
            return "tag " + std::to_string(tags[0].id) + " of " + number(tags[0].size) + " m, " +
                   print(single);
          },
          [&](const AprilGrid& grid) {
            return "grid of " + times(grid.columns, grid.rows) + " tags of " +
                   number(grid.tag_size) + " m, " + print(grid);
          },
          [&](const Checkerboard& squares) {
            return "checkerboard of " + times(squares.columns, squares.rows) + " corners" +
                   apart(squares.column_spacing);
          },
          [&](const Charuco& charuco) {
            return "charuco of " + times(charuco.square_columns, charuco.square_rows) +
                   " squares, " + charuco.dictionary + apart(charuco.square_size);
          },
          [&](const CircleGrid& grid) {
            return std::string(grid.asymmetric ? "asymmetric " : "") + "grid of " +
                   times(grid.columns, grid.rows) + " circles" + apart(grid.spacing);
          }},
      board.pattern);
}

py::dict board_to_dict(const Board& board) {
  py::dict fields = std::visit([](const auto& kind) { return arguments_of(kind); }, board.pattern);
  add_substrate(board.substrate, fields);
  fields["kind"] = board_kind(board);
  return fields;
}

Board board_from_dict(const py::dict& fields) {
  if (!fields.contains("kind")) throw Error("fields: must have the key \"kind\"");
  const auto kind = py::cast<std::string>(py::str(fields["kind"]));
  if (std::ranges::find(kKinds, kind) == std::end(kKinds))
    throw Error(
        "fields: kind: must be charuco, checkerboard, circle_grid, grid, points or tags, got " +
        kind);
  const auto arguments = py::reinterpret_steal<py::dict>(PyDict_Copy(fields.ptr()));
  arguments.attr("pop")("kind");
  if (arguments.contains("board_from_tags")) {
    py::list poses;
    for (const py::handle& pose : arguments["board_from_tags"]) {
      if (!py::isinstance<py::dict>(pose) || !pose.contains("quaternion") ||
          !pose.contains("translation"))
        throw Error("fields: board_from_tags: must have a quaternion and a translation");
      poses.append(py::type::of<Pose>()(pose["quaternion"], pose["translation"]));
    }
    arguments["board_from_tags"] = poses;
  }
  const py::dict substrate;
  for (const char* key : {"flatness", "print"})
    if (arguments.contains(key)) substrate[key] = arguments.attr("pop")(key);
  const py::object board = py::type::of<Board>().attr(kind.c_str())(**arguments);
  return py::cast<Board>(board.attr("made_of")(**substrate));
}

namespace {

void define_grids(py::class_<Board>& board) {
  board
      .def_static("grid", &grid, py::arg("columns"), py::arg("rows"), py::arg("tag_size"),
                  py::arg("tag_spacing"), py::arg("family") = "tag36h11",
                  py::arg("border_bits") = 2, py::arg("corner_squares") = py::none(),
                  py::arg("first_id") = 0,
                  "Kalibr's AprilGrid: `columns` x `rows` tags of `tag_size` metres, with gaps of "
                  "`tag_spacing` tag sizes; ids row by row from below. Origin: the outer lower "
                  "left corner of the first tag, x right, y up, z to the viewer. `border_bits`: "
                  "width of the black border in cells, 2 as Kalibr prints, 1 for plain tags. "
                  "`corner_squares`: Kalibr's black squares between the tags (None: with a border "
                  "of 2).")
      .def_static("checkerboard", &checkerboard, py::arg("columns"), py::arg("rows"),
                  py::arg("spacing"), py::arg("row_spacing") = py::none(),
                  py::arg("starts_black") = true, py::arg("first_id") = 0,
                  "A checkerboard of `columns` x `rows` corners where four squares meet (one less "
                  "than squares), `spacing` metres apart; `row_spacing` if it differs along y. "
                  "Origin: the lower left corner, x right, y up, z to the viewer; ids row by row "
                  "from below. `starts_black`: the square to its lower left is black.")
      .def_static("charuco", &charuco, py::arg("square_columns"), py::arg("square_rows"),
                  py::arg("square_size"), py::arg("marker_size"), py::arg("dictionary"),
                  py::arg("legacy") = false, py::arg("first_id") = 0,
                  py::arg("first_marker_id") = 0,
                  "A ChArUco board as OpenCV's: squares of `square_size` and markers of "
                  "`marker_size` metres from a `dictionary` (tag_dictionary_names()). `legacy`: "
                  "the pattern of OpenCV before 4.6. Origin: the lower left inner corner, x right, "
                  "y up, z to the viewer.")
      .def_static(
          "circle_grid", &circle_grid, py::arg("columns"), py::arg("rows"), py::arg("spacing"),
          py::arg("diameter"), py::arg("asymmetric") = false, py::arg("first_id") = 0,
          "A grid of black discs of `diameter` metres, `spacing` metres apart, as OpenCV's. "
          "`asymmetric`: `rows` are `spacing` apart and discs of one row twice that, and "
          "the disc of column c and row r, from above, is at (2 c + r mod 2) spacing. "
          "Origin: the lower left of the grid, x right, y up, z to the viewer; ids row by "
          "row from below.");
}

}  // namespace

void define_board_constructors(py::class_<Board>& board) {
  define_grids(board);
  board
      .def_static("tag", &one_tag, py::arg("size"), py::arg("id") = 0,
                  py::arg("family") = "tag36h11", py::arg("border_bits") = 1,
                  "One tag of `size` metres from black edge to black edge. Origin: its centre, x "
                  "right, y up, z to the viewer.")
      .def_static("tags", &tags, py::arg("ids"), py::arg("size"), py::arg("board_from_tags"),
                  py::arg("family") = "tag36h11", py::arg("border_bits") = 1,
                  "Single tags that are rigid together: ids (N,), the size of all or sizes (N,), "
                  "metres, and the poses of the tags on the board: a list of N Pose, or (N, 4, 4).")
      .def_static("points", &points, py::arg("positions"), py::arg("ids") = py::none(),
                  "Measured points (N, 3), metres; ids (N,), by default 0, 1, ..")
      .def_static("from_dict", &board_from_dict, py::arg("fields"), "The board of `to_dict()`.");
}

}  // namespace tagcal::python
