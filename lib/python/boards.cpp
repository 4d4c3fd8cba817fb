#include "python/boards.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Geometry>
#include <set>
#include <string>
#include <variant>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {
namespace {

PlacedBoard placed_board(py::handle object, const std::string& name) {
  if (py::isinstance<PlacedBoard>(object)) {
    PlacedBoard placed = py::cast<PlacedBoard>(object);
    if (!placed.world_from_board.matrix().allFinite())
      throw Error(name + ": world_from_board: must be finite");
    return placed;
  }
  if (py::isinstance<Board>(object)) return {py::cast<Board>(object), Pose()};
  throw Error(name + ": must be a Board, a PlacedBoard or a list of these, got " +
              type_name(object));
}

void check_ids(const std::vector<PlacedBoard>& boards, const char* name) {
  std::set<CornerId> seen;
  std::set<std::pair<std::string, int>> tags;
  for (const PlacedBoard& board : boards) {
    for (const TargetPoint& point : target_points(board.board))
      if (!seen.insert(point.id).second)
        throw Error(std::string(name) + ": two boards have id " + std::to_string(point.id.tag_id));
    const auto kind = tag_kind(board.board);
    for (const Tag& tag : tags_of(board.board))
      if (!tags.emplace(kind->family, tag.id).second)
        throw Error(std::string(name) + ": two boards have marker " + std::to_string(tag.id) +
                    " of " + kind->family);
  }
}

}  // namespace

std::vector<PlacedBoard> boards_of(const TargetLike& target, const char* name) {
  std::vector<PlacedBoard> boards;
  if (py::isinstance<py::list>(target) || py::isinstance<py::tuple>(target)) {
    std::size_t i = 0;
    for (const py::handle& element : target)
      boards.push_back(placed_board(element, std::string(name) + "[" + std::to_string(i++) + "]"));
    if (boards.empty()) throw Error(std::string(name) + ": must have a board");
    check_ids(boards, name);
  } else {
    boards.push_back(placed_board(target, name));
  }
  return boards;
}

namespace {

std::vector<Eigen::Vector3d> positions_of(const Board& board) {
  std::vector<Eigen::Vector3d> positions;
  for (const TargetPoint& point : target_points(board)) positions.push_back(point.position);
  return positions;
}

py::array_t<int> ids_of(const Board& board) {
  std::vector<CornerId> ids;
  for (const TargetPoint& point : target_points(board)) ids.push_back(point.id);
  return array_of_ids(ids);
}

Eigen::Vector3d extent(const Board& board) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& position : positions_of(board)) box.extend(position);
  return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.sizes());
}

using NameOrShare = std::variant<double, std::string>;

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

}  // namespace

void add_substrate(const Substrate& substrate, py::dict& fields) {
  if (substrate.flatness != Substrate().flatness)
    fields["flatness"] = name_or_share(substrate.flatness);
  if (substrate.print != Substrate().print) fields["print"] = name_or_share(substrate.print);
}

namespace {

void define_points(py::class_<Board>& board) {
  board
      .def_property_readonly("kind", &board_kind,
                             "\"grid\", \"checkerboard\", \"charuco\", \"circle_grid\", \"tags\" "
                             "or \"points\": the constructor of its like.")
      .def_property_readonly("ids", &ids_of,
                             "(N, 2), int, of what can be observed, ascending: tag and corner 0..3 "
                             "(lower-left, lower-right, upper-right, upper-left of the upright "
                             "tag); of other targets the point and 0.")
      .def_property_readonly(
          "positions",
          [](const Board& b) {
            return array_of(std::span<const Eigen::Vector3d>(positions_of(b)));
          },
          "(N, 3), metres, of the same points, in the board's frame.")
      .def_property_readonly("extent_m", &extent, "(3,): sides of the box around the points.")
      .def_property_readonly(
          "tag_ids",
          [](const Board& b) {
            std::vector<int> ids;
            for (const Tag& tag : tags_of(b)) ids.push_back(tag.id);
            return ids;
          },
          "The ids of the tags; of a ChArUco board those of its markers.")
      .def_property_readonly(
          "family", [](const Board& b) { return tag_kind(b).value_or(TagKind{}).family; },
          "Of the tags, or the dictionary of the markers.")
      .def_property_readonly(
          "border_bits", [](const Board& b) { return tag_kind(b).value_or(TagKind{}).border_bits; },
          "Width of the tags' border in cells.")
      .def("__len__", [](const Board& b) { return target_points(b).size(); });
}

void define_make(py::class_<Board>& board) {
  board
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
      .def("to_dict", &board_to_dict, "Kind and arguments of its constructor, as plain values.")
      .def(
          "__eq__",
          [](const Board& a, const py::object& other) {
            return py::isinstance<Board>(other) &&
                   board_to_dict(a).equal(board_to_dict(py::cast<const Board&>(other)));
          },
          py::arg("other"))
      .def("__repr__", [](const Board& b) { return "<Board " + board_text(b) + ">"; })
      .def(py::pickle(&board_to_dict, &board_from_dict));
}

void bind_placed_board(py::module_& m) {
  Record<PlacedBoard>(m, "PlacedBoard", "A board and its place in the world.")
      .field("board", &PlacedBoard::board, "The board.")
      .field("world_from_board", &PlacedBoard::world_from_board, "Its pose.")
      .representation([](const PlacedBoard& placed) {
        const Eigen::Vector3d& t = placed.world_from_board.translation();
        return board_text(placed.board) + ", at (" + number(t[0], 4) + ", " + number(t[1], 4) +
               ", " + number(t[2], 4) + ") m";
      })
      .def(py::init([](const Board& board, const PoseLike& world_from_board) {
             return PlacedBoard{board, pose_of(world_from_board, "world_from_board")};
           }),
           py::arg("board"), py::arg("world_from_board"));
}

}  // namespace

void bind_boards(py::module_& m) {
  py::class_<Board> board(m, "Board", "A calibration target: tags, a checkerboard, or points.");
  define_board_constructors(board);
  define_points(board);
  define_make(board);
  bind_placed_board(m);
  bind_view(m);
  m.def("tag_family_names", &tag_family_names, "The families of AprilTags that are known.");
  m.def("tag_dictionary_names", &tag_dictionary_names,
        "OpenCV's dictionaries of markers, which are families too: \"DICT_4X4_50\", ..");
}

}  // namespace tagcal::python
