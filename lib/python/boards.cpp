#include "python/boards.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <set>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {
namespace {

PlacedBoard placed_board(py::handle object, const std::string& name) {
  if (py::isinstance<PlacedBoard>(object)) return py::cast<PlacedBoard>(object);
  if (py::isinstance<Board>(object)) return {py::cast<Board>(object), Pose()};
  throw Error(name + ": must be a Board, a PlacedBoard or a list of these, got " +
              py::cast<std::string>(py::type::handle_of(object).attr("__name__")));
}

void check_ids(const std::vector<PlacedBoard>& boards, const char* name) {
  std::set<CornerId> seen;
  for (const PlacedBoard& board : boards)
    for (const TargetPoint& point : target_points(board.board))
      if (!seen.insert(point.id).second)
        throw Error(std::string(name) + ": two boards have id " + std::to_string(point.id.tag_id));
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

// ids: (N, 2) of tag and corner, or (N,) of points.
std::vector<CornerId> corner_ids(const ArrayLike& ids) {
  const py::array_t<double> array = real_array(ids, "ids");
  const bool are_pairs = array.ndim() == 2 && array.shape(1) == 2;
  if (!are_pairs && array.ndim() != 1)
    throw Error("ids: must have the shape (N, 2), of tag and corner, or (N,), of points");
  constexpr double kLargest = 1 << 30;  // numeric: fits an int
  std::vector<CornerId> result(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double tag = array.data()[are_pairs ? 2 * i : i];
    const double corner = are_pairs ? array.data()[2 * i + 1] : 0;
    if (!(tag >= 0 && tag <= kLargest && tag == std::floor(tag)) ||
        !(corner >= 0 && corner <= 3 && corner == std::floor(corner)))
      throw Error("ids: must be whole numbers >= 0, corners 0 to 3, got (" + number(tag, 17) +
                  ", " + number(corner, 17) + ") in row " + std::to_string(i));
    result[i] = {static_cast<int>(tag), static_cast<int>(corner)};
  }
  return result;
}

View view_of(const ArrayLike& ids, const ArrayLike& pixels, const ArrayLike& covariances,
             const std::string& image) {
  const std::vector<CornerId> corners = corner_ids(ids);
  const Rows2 rows(pixels, "pixels");
  check_same_length(corners.size(), "ids", rows.size(), "pixels");
  const std::vector<Matrix2> matrices = covariances2(covariances, "covariances", rows.size());
  View view{image, {}};
  std::set<CornerId> seen;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!seen.insert(corners[i]).second)
      throw Error("ids: (" + std::to_string(corners[i].tag_id) + ", " +
                  std::to_string(corners[i].corner) + ") occurs twice");
    view.observations.push_back({corners[i], rows[i], std::nullopt});
    if (!matrices.empty()) view.observations.back().covariance_px2 = matrices[i];
  }
  return view;
}

py::array_t<int> ids_of(const View& view) {
  py::array_t<int> ids({static_cast<py::ssize_t>(view.observations.size()), py::ssize_t{2}});
  int* id = ids.mutable_data();
  for (const Observation& seen : view.observations) {
    *id++ = seen.id.tag_id;
    *id++ = seen.id.corner;
  }
  return ids;
}

py::array_t<double> pixels_of(const View& view) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Observation& seen : view.observations) pixels.push_back(seen.pixel);
  return array_of(std::span<const Eigen::Vector2d>(pixels));
}

py::array_t<double> covariances_of(const View& view) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(view.observations.size()), py::ssize_t{2}, py::ssize_t{2}});
  double* values = array.mutable_data();
  for (const Observation& seen : view.observations) {
    const Matrix2 c = seen.covariance_px2.value_or(Matrix2::Constant(std::nan("")));
    values = std::copy_n(c.data(), 4, values);
  }
  return array;
}

void bind_view(py::module_& m) {
  Record<View>(m, "View", "The corners that were seen in one picture.")
      .field("image", &View::image, "The name of the picture; may be empty.")
      .field("ids", &ids_of,
             "(N, 2), int: tag and corner 0..3 (lower-left, lower-right, upper-right, upper-left "
             "of the upright tag); of other targets the point and 0.")
      .field("pixels", &pixels_of, "(N, 2).")
      .field("covariances", &covariances_of, "(N, 2, 2), px^2; NaN for a corner without one.")
      .representation([](const View& view) {
        return "\"" + view.image + "\" " + std::to_string(view.observations.size()) + " corners";
      })
      .def(py::init(&view_of), py::arg("ids"), py::arg("pixels"),
           py::arg("covariances") = py::none(), py::arg("image") = "",
           "From ids (N, 2) of tag and corner, or (N,) of points, and pixels (N, 2); covariances "
           "(N, 2, 2), or (2, 2) for all.")
      .def("__len__", [](const View& view) { return view.observations.size(); });
}

}  // namespace

void bind_boards(py::module_& m) {
  py::class_<Board>(m, "Board", "A calibration target: tags, a checkerboard, or measured points.");
  py::class_<PlacedBoard>(m, "PlacedBoard", "A board and its place in the world.")
      .def(py::init([](const Board& board, const PoseLike& world_from_board) {
             return PlacedBoard{board, pose_of(world_from_board, "world_from_board")};
           }),
           py::arg("board"), py::arg("world_from_board"));
  bind_view(m);
}

}  // namespace tagcal::python
