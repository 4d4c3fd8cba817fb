#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "python/arrays.hpp"
#include "python/boards.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {

py::array_t<int> array_of_ids(std::span<const CornerId> ids) {
  py::array_t<int> array({static_cast<py::ssize_t>(ids.size()), py::ssize_t{2}});
  int* value = array.mutable_data();
  for (const CornerId& id : ids) {
    *value++ = id.tag_id;
    *value++ = id.corner;
  }
  return array;
}

namespace {

// Matrices as covariances2 reads them, but with a value only for those that are not all NaN.
std::vector<std::optional<Matrix2>> known_covariances(const ArrayLike& argument, std::size_t n) {
  if (argument.is_none()) return std::vector<std::optional<Matrix2>>(n);
  py::array_t<double> array = real_array(argument, "covariances");
  std::vector<bool> is_known(n, true);
  if (array.ndim() == 3 && array.size() == static_cast<py::ssize_t>(4 * n)) {
    array = py::array_t<double>(array.request());  // a copy
    for (std::size_t i = 0; i < n; ++i) {
      const std::span<double, 4> matrix(array.mutable_data() + 4 * i, 4);
      is_known[i] = !std::ranges::all_of(matrix, [](double value) { return std::isnan(value); });
      if (!is_known[i]) std::ranges::copy(std::array{1.0, 0.0, 0.0, 1.0}, matrix.begin());
    }
  }
  const std::vector<Matrix2> matrices = covariances2(array, "covariances", n);
  std::vector<std::optional<Matrix2>> known(n);
  for (std::size_t i = 0; i < n; ++i)
    if (is_known[i]) known[i] = matrices[i];
  return known;
}

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
  const std::vector<std::optional<Matrix2>> matrices = known_covariances(covariances, rows.size());
  View view{image, {}};
  std::set<CornerId> seen;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!seen.insert(corners[i]).second)
      throw Error("ids: (" + std::to_string(corners[i].tag_id) + ", " +
                  std::to_string(corners[i].corner) + ") occurs twice");
    view.observations.push_back({corners[i], rows[i], matrices[i]});
  }
  return view;
}

py::array_t<int> ids_of(const View& view) {
  std::vector<CornerId> ids;
  for (const Observation& seen : view.observations) ids.push_back(seen.id);
  return array_of_ids(ids);
}

py::array_t<double> view_pixels(const View& view) {
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

}  // namespace

void bind_view(py::module_& m) {
  Record<View>(m, "View", "The corners that were seen in one picture.")
      .field("image", &View::image, "The name of the picture; may be empty.")
      .field("ids", &ids_of,
             "(N, 2), int: tag and corner 0..3 (lower-left, lower-right, upper-right, upper-left "
             "of the upright tag); of other targets the point and 0.")
      .field("pixels", &view_pixels, "(N, 2).")
      .field("covariances", &covariances_of, "(N, 2, 2), px^2; NaN for a corner without one.")
      .representation([](const View& view) {
        return "\"" + view.image + "\" " + std::to_string(view.observations.size()) + " corners";
      })
      .def(py::init(&view_of), py::arg("ids"), py::arg("pixels"),
           py::arg("covariances") = py::none(), py::arg("image") = "",
           "From ids (N, 2) of tag and corner, or (N,) of points, and pixels (N, 2); covariances "
           "(N, 2, 2), px^2, NaN for a corner without one, or (2, 2) for all.")
      .def(
          "__len__", [](const View& view) { return view.observations.size(); },
          "The number of corners.");
}

}  // namespace tagcal::python
