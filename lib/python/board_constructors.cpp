#include "python/board_constructors.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <variant>

#include "python/arrays.hpp"
#include "python/boards.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/scene/print/printed_tag.hpp"

namespace tagcal::python {
namespace {

using NameOrShare = std::variant<double, std::string>;

// Throws Error if the family lacks a tag or cannot have the border, and for positions beyond
// double.
Board checked(Board board) {
  if (!board.tags.empty()) {
    const TagFamily family =
        internal::with_border(tag_family(board.family, board.border_bits), board);
    internal::printed_tag(family, std::ranges::max_element(board.tags, {}, &Tag::id)->id);
  }
  for (const TargetPoint& point : target_points(board))
    if (!point.position.allFinite()) throw Error("board: its sizes are too large");
  return board;
}

Board grid(int columns, int rows, double tag_size, double tag_spacing, const std::string& family,
           int border_bits, std::optional<bool> corner_squares, int first_id) {
  return checked(grid_board({columns, rows, tag_size, tag_spacing, first_id}, family, border_bits,
                            corner_squares.value_or(border_bits == 2)));
}

Board checkerboard(int columns, int rows, double spacing, std::optional<double> row_spacing,
                   bool starts_black, int first_id) {
  return checked(checkerboard_board(
      {columns, rows, spacing, row_spacing.value_or(spacing), starts_black, first_id}));
}

Board charuco(int square_columns, int square_rows, double square_size, double marker_size,
              const std::string& dictionary, bool legacy, int first_id, int first_marker_id) {
  if (square_columns < 3 || square_rows < 3)
    throw Error("board: must have 3 x 3 squares or more, got " + std::to_string(square_columns) +
                " x " + std::to_string(square_rows));
  return checked(
      charuco_board({square_columns - 1, square_rows - 1, square_size, square_size, true, first_id},
                    {marker_size, dictionary, legacy, first_marker_id}));
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
  for (std::size_t i = 0; i < n; ++i) {
    sizes[i] = array.data()[is_one ? 0 : i];
    if (!(sizes[i] > 0) || !std::isfinite(sizes[i]))
      throw Error("size: must be > 0, got " + number(sizes[i]));
  }
  return sizes;
}

Board tags(const ArrayLike& ids, const ArrayLike& size, const PosesLike& board_from_tags,
           const std::string& family, int border_bits) {
  const std::vector<int> numbers = different_ids(ids, "ids");
  const std::vector<double> sizes = tag_sizes(size, numbers.size());
  const std::vector<Pose> poses = poses_of(board_from_tags, "board_from_tags");
  check_same_length(numbers.size(), "ids", poses.size(), "board_from_tags");
  Board board;
  board.family = family;
  board.border_bits = border_bits;
  board.corner_squares = false;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    board.tags.push_back({numbers[i], sizes[i], poses[i]});
  return checked(board);
}

Board one_tag(double size, int id, const std::string& family, int border_bits) {
  if (!(size > 0) || !std::isfinite(size)) throw Error("size: must be > 0, got " + number(size));
  if (id < 0) throw Error("id: must be >= 0, got " + std::to_string(id));
  Board board;
  board.family = family;
  board.border_bits = border_bits;
  board.corner_squares = false;
  board.tags = {{id, size, Pose()}};
  return checked(board);
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
  Board board;
  board.border_bits = 1;
  board.corner_squares = false;
  for (std::size_t i = 0; i < rows.size(); ++i) board.points.push_back({{numbers[i], 0}, rows[i]});
  return board;
}

py::dict dict_of_tags(const Board& board) {
  py::list ids, sizes, poses;
  for (const Tag& tag : board.tags) {
    ids.append(tag.id);
    sizes.append(tag.size);
    poses.append(py::cast(tag.board_from_tag).attr("to_dict")());
  }
  using namespace py::literals;
  return py::dict("ids"_a = ids, "size"_a = sizes, "board_from_tags"_a = poses,
                  "family"_a = board.family, "border_bits"_a = board.border_bits);
}

py::dict dict_of_points(const Board& board) {
  py::list ids, positions;
  for (const TargetPoint& point : board.points) {
    ids.append(point.id.tag_id);
    positions.append(std::vector(point.position.data(), point.position.data() + 3));
  }
  using namespace py::literals;
  return py::dict("positions"_a = positions, "ids"_a = ids);
}

Tolerance tolerance_of(const NameOrShare& argument, const char* name) {
  if (const double* const share = std::get_if<double>(&argument)) return *share;
  const auto& word = std::get<std::string>(argument);
  const auto material = material_named(word);
  if (!material)
    throw Error(std::string(name) + ": must be paper, aluminium, glass or a share, got \"" + word +
                "\"");
  return *material;
}

NameOrShare name_or_share(const Tolerance& tolerance) {
  if (const double* const share = std::get_if<double>(&tolerance)) return *share;
  return std::string(material_name(std::get<Material>(tolerance)));
}

Board made_of(Board board, const NameOrShare& flatness, const NameOrShare& print) {
  board.substrate = {tolerance_of(flatness, "flatness"), tolerance_of(print, "print")};
  check_substrate(board.substrate);
  return board;
}

// Without defaults, as the files of targets.
void add_substrate(const Substrate& substrate, py::dict& fields) {
  if (substrate.flatness != Substrate().flatness)
    fields["flatness"] = name_or_share(substrate.flatness);
  if (substrate.print != Substrate().print) fields["print"] = name_or_share(substrate.print);
}

}  // namespace

std::string board_kind(const Board& board) {
  if (board.grid) return "grid";
  if (board.charuco) return "charuco";
  if (board.checkerboard) return "checkerboard";
  return board.points.empty() ? "tags" : "points";
}

py::dict board_to_dict(const Board& board) {
  using namespace py::literals;
  py::dict fields;
  if (const auto& g = board.grid) {
    fields = py::dict("columns"_a = g->columns, "rows"_a = g->rows, "tag_size"_a = g->tag_size,
                      "tag_spacing"_a = g->tag_spacing, "family"_a = board.family,
                      "border_bits"_a = board.border_bits,
                      "corner_squares"_a = board.corner_squares, "first_id"_a = g->first_id);
  } else if (const auto& m = board.charuco) {
    const Checkerboard& c = *board.checkerboard;
    fields = py::dict("square_columns"_a = c.columns + 1, "square_rows"_a = c.rows + 1,
                      "square_size"_a = c.column_spacing, "marker_size"_a = m->size,
                      "dictionary"_a = m->dictionary, "legacy"_a = m->legacy,
                      "first_id"_a = c.first_id, "first_marker_id"_a = m->first_marker_id);
  } else if (const auto& c = board.checkerboard) {
    fields = py::dict("columns"_a = c->columns, "rows"_a = c->rows, "spacing"_a = c->column_spacing,
                      "row_spacing"_a = c->row_spacing, "starts_black"_a = c->starts_black,
                      "first_id"_a = c->first_id);
  } else {
    fields = board.points.empty() ? dict_of_tags(board) : dict_of_points(board);
  }
  add_substrate(board.substrate, fields);
  fields["kind"] = board_kind(board);
  return fields;
}

Board board_from_dict(const py::dict& fields) {
  if (!fields.contains("kind")) throw Error("fields: must have the key \"kind\"");
  const auto kind = py::cast<std::string>(py::str(fields["kind"]));
  const std::set<std::string> kinds = {"charuco", "checkerboard", "grid", "points", "tags"};
  if (!kinds.contains(kind))
    throw Error("fields: kind: must be charuco, checkerboard, grid, points or tags, got " + kind);
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

void define_board_constructors(py::class_<Board>& board) {
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
      .def("made_of", &made_of, py::arg("flatness") = "paper", py::arg("print") = "paper",
           "This board of another make: standard deviations before any picture of its bends and "
           "twist, as a share of its diagonal, and of the share by which its print is longer "
           "along y than along x. Each is \"paper\", \"aluminium\", \"glass\" or a share.")
      .def_property_readonly(
          "flatness", [](const Board& b) { return name_or_share(b.substrate.flatness); },
          "\"paper\", \"aluminium\", \"glass\" or a share: see `made_of`.")
      .def_property_readonly(
          "print", [](const Board& b) { return name_or_share(b.substrate.print); },
          "\"paper\", \"aluminium\", \"glass\" or a share: see `made_of`.")
      .def_static("from_dict", &board_from_dict, py::arg("fields"), "The board of `to_dict()`.");
}

}  // namespace tagcal::python
