#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/calibration.hpp"
#include "python/camera.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/uncertainty/seen_region.hpp"

// Binds the region of the corners in an image, and grids of nodes over it.

namespace tagcal::python {
namespace {

ImageGrid checked_grid(const ArrayLike& size, int columns, int rows) {
  constexpr int kMost = 1 << 18;  // numeric: nodes; a map of them takes seconds and 100 MB
  if (columns < 2 || rows < 2 || columns > kMost / rows)
    throw Error("columns, rows: must be >= 2, at most " + std::to_string(kMost) +
                " nodes in all, got " + std::to_string(columns) + " and " + std::to_string(rows));
  return {size_of_argument(size, "size"), columns, rows};
}

py::array_t<double> nodes_of_grid(const ImageGrid& grid) {
  return array_of(std::span<const Eigen::Vector2d>(grid.pixels()))
      .reshape({grid.rows, grid.columns, 2});
}

py::array_t<bool> contained(const SeenRegion& region, const ArrayLike& pixels) {
  const Rows2 rows(pixels, "pixels", Rows2::Check::none);
  py::array_t<bool> inside(rows.is_single() ? std::vector<py::ssize_t>()
                                            : std::vector{static_cast<py::ssize_t>(rows.size())});
  for (std::size_t i = 0; i < rows.size(); ++i)
    inside.mutable_data()[i] = rows[i].allFinite() && region.contains(rows[i]);
  return inside;
}

SeenRegion region_of(const ArrayLike& size, const ArrayLike& pixels) {
  const ImageSize image_size = size_of_argument(size, "size");
  return {image_size, Rows2(pixels, "pixels").span()};
}

void bind_seen_region(py::module_& m) {
  Record<SeenRegion>(m, "SeenRegion",
                     "The convex hull of the corners in an image. A lens is extrapolated outside "
                     "of it.")
      .field(
          "hull", [](const SeenRegion& r) { return array_of(std::span(r.hull())); },
          "(N, 2), pixels: its corners, in the direction from x to y; none if it is empty.")
      .field("share", &SeenRegion::share, "Of the image's area.")
      .field("missing_parts", &SeenRegion::missing_parts,
             "The thirds and corners of the image outside of it, such as \"left third\".")
      .field("gaps", &SeenRegion::gaps, "The same as a sentence; None if no part is missing.")
      .representation(
          [](const SeenRegion& r) { return number(100 * r.share(), 3) + " % of the image"; })
      .def(py::init(&region_of), py::arg("size"), py::arg("pixels"),
           "The region of pixels (N, 2) in an image of `size` (width, height).")
      .def("contains", &contained, py::arg("pixels"), "True for each pixel (N, 2) inside of it.")
      .def(
          "samples",
          [](const SeenRegion& r) {
            return array_of(std::span<const Eigen::Vector2d>(r.samples()));
          },
          "At least 12 pixels (N, 2), evenly over the region; none if it is empty.");
}

}  // namespace

NumbersByName by_name(const Lens& lens, const std::vector<double>& values) {
  return numbers_by_name(parameter_names(lens), values);
}

void check_distance(double value, const char* name) {
  if (!(value > 0))
    throw Error(std::string(name) + ": must be > 0, infinity too, got " + number(value));
}

std::string distance_text(double distance_m) {
  return std::isfinite(distance_m) ? "at " + number(distance_m, 4) + " m" : "at infinity";
}

void bind_regions(py::module_& m) {
  Record<ImageGrid>(m, "ImageGrid", "Nodes over an image, from border to border.")
      .field("size", &ImageGrid::size, "(width, height) of the image.")
      .field("columns", &ImageGrid::columns, "Number of nodes in x.")
      .field("rows", &ImageGrid::rows, "Number of nodes in y.")
      .representation([](const ImageGrid& g) {
        return std::to_string(g.columns) + " x " + std::to_string(g.rows) + " nodes over " +
               size_text(g.size) + " px";
      })
      .def(py::init(&checked_grid), py::arg("size"), py::arg("columns") = 21, py::arg("rows") = 13)
      .def_property_readonly("pixels", &nodes_of_grid,
                             "(rows, columns, 2): the nodes; the first is (-0.5, -0.5).");
  bind_seen_region(m);
}

}  // namespace tagcal::python
