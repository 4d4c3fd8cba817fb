#include "python/dataset.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <optional>

#include "python/bindings.hpp"
#include "python/boards.hpp"
#include "python/camera.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/io/dataset_file.hpp"

namespace tagcal::python {
namespace {

// One array per view: the elements of a list, or of an array along its first axis.
std::vector<py::object> elements_of(const ArrayLike& argument, const char* name) {
  const bool is_list = py::isinstance<py::list>(argument) || py::isinstance<py::tuple>(argument);
  if (!is_list &&
      !(py::isinstance<py::array>(argument) && py::cast<int>(argument.attr("ndim")) > 0))
    throw Error(std::string(name) + ": must be a list of arrays, one for each view, got " +
                type_name(argument));
  std::vector<py::object> arrays;
  for (const py::handle& element : argument)
    arrays.push_back(py::reinterpret_borrow<py::object>(element));
  return arrays;
}

// (N, 1, K) and (1, N, K), the shapes of OpenCV's vectors, as (N, K).
py::object without_axis_of_one(const py::object& argument, const char* name) {
  const py::array_t<double> array = real_array(argument, name);
  if (array.ndim() != 3 || (array.shape(0) != 1 && array.shape(1) != 1)) return array;
  const py::ssize_t n = array.shape(0) == 1 ? array.shape(1) : array.shape(0);
  return py::array_t<double>(array).reshape({n, array.shape(2)});
}

std::string element_name(const char* name, std::size_t i) {
  return std::string(name) + "[" + std::to_string(i) + "]";
}

// Throws Error for a pixel outside the image, where no corner is seen: mostly the size is given as
// (height, width).
void check_inside(const Eigen::Vector2d& pixel, const ImageSize& size, const std::string& name) {
  constexpr double kMargin = 1;  // numeric: px; a fitted corner may lie beyond the last pixel
  const Eigen::Vector2d last(size.width - 1 + kMargin, size.height - 1 + kMargin);
  if ((pixel.array() >= -kMargin).all() && (pixel.array() <= last.array()).all()) return;
  throw Error(name + ": the pixel (" + number(pixel.x()) + ", " + number(pixel.y()) +
              ") is outside the image; size, (width, height), is (" + std::to_string(size.width) +
              ", " + std::to_string(size.height) + ")");
}

// An array (N, 3) is what all views show; a list holds one array for each view.
bool is_common(const ArrayLike& points) {
  return py::isinstance<py::array>(points) && py::cast<int>(points.attr("ndim")) == 2;
}

std::vector<std::vector<Correspondence>> correspondences_of(const ArrayLike& object_points,
                                                            const ArrayLike& image_points,
                                                            const ImageSize& size) {
  const std::vector<py::object> pixels = elements_of(image_points, "image_points");
  const bool common = is_common(object_points);
  const std::vector<py::object> points = common
                                             ? std::vector<py::object>(pixels.size(), object_points)
                                             : elements_of(object_points, "object_points");
  if (points.size() != pixels.size())
    throw Error("image_points: must have as many views as object_points (" +
                std::to_string(points.size()) + "), got " + std::to_string(pixels.size()));
  std::vector<std::vector<Correspondence>> views(points.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::string points_name =
        common ? std::string("object_points") : element_name("object_points", v);
    const std::string pixels_name = element_name("image_points", v);
    const Rows3 x(without_axis_of_one(points[v], points_name.c_str()), points_name.c_str());
    const Rows2 p(without_axis_of_one(pixels[v], pixels_name.c_str()), pixels_name.c_str());
    check_same_length(x.size(), points_name.c_str(), p.size(), pixels_name.c_str());
    for (std::size_t i = 0; i < x.size(); ++i) {
      check_inside(p[i], size, pixels_name);
      views[v].push_back({x[i], p[i]});
    }
  }
  return views;
}

}  // namespace

Dataset dataset_from_points(const ArrayLike& object_points, const ArrayLike& image_points,
                            const ArrayLike& size, const std::vector<std::string>& images) {
  const ImageSize image_size = size_of_argument(size, "size");
  const auto views = correspondences_of(object_points, image_points, image_size);
  if (!images.empty() && images.size() != views.size())
    throw Error("images: must have a name for each view (" + std::to_string(views.size()) +
                "), got " + std::to_string(images.size()));
  py::gil_scoped_release release;
  Dataset dataset = dataset_from_correspondences(views, image_size);
  for (std::size_t v = 0; v < images.size(); ++v) dataset.views[v].image = images[v];
  return dataset;
}

namespace {

// Throws Error for a corner that the boards do not have, or outside the image.
void check_views(const std::vector<View>& views, const std::vector<PlacedBoard>& boards,
                 const ImageSize& size) {
  const auto points = points_in_world(boards);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::string name = element_name("views", v);
    for (const Observation& seen : views[v].observations) {
      if (!points.contains(seen.id))
        throw Error(name + ": has the corner (" + std::to_string(seen.id.tag_id) + ", " +
                    std::to_string(seen.id.corner) + "), which the target does not have");
      check_inside(seen.pixel, size, name);
    }
  }
}

Dataset dataset_of(const ArrayLike& size, const TargetLike& target, std::vector<View> views,
                   std::optional<Truth> truth) {
  const ImageSize image_size = size_of_argument(size, "size");
  std::vector<PlacedBoard> boards = boards_of(target, "target");
  check_views(views, boards, image_size);
  if (truth && truth->camera.image_size != image_size)
    throw Error("truth: its camera must have the size of the data set");
  return {image_size, std::move(boards), std::move(views), std::move(truth)};
}

using ListOfArrays = std::vector<py::array_t<double>>;

// OpenCV's lists: object_points and image_points.
std::pair<ListOfArrays, ListOfArrays> lists_of(const Dataset& dataset) {
  const auto target = points_in_world(dataset.boards);
  std::pair<ListOfArrays, ListOfArrays> lists;
  for (const View& view : dataset.views) {
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    for (const Correspondence& c : view_correspondences(view, target).correspondences) {
      points.push_back(c.point);
      pixels.push_back(c.pixel);
    }
    lists.first.push_back(array_of(std::span<const Eigen::Vector3d>(points)));
    lists.second.push_back(array_of(std::span<const Eigen::Vector2d>(pixels)));
  }
  return lists;
}

std::string dataset_text(const Dataset& dataset) {
  std::size_t corners = 0;
  for (const View& view : dataset.views) corners += view.observations.size();
  return size_text(dataset.image_size) + ", " + counted(dataset.boards.size(), "board") + ", " +
         counted(dataset.views.size(), "view") + ", " + counted(corners, "corner") +
         (dataset.truth ? ", with truth" : "");
}

void bind_truth(py::module_& m) {
  Record<Truth>(m, "Truth", "The true camera and poses of a synthetic data set.")
      .field("camera", &Truth::camera, "The true Camera.")
      .field("model", &Truth::model,
             "The smallest model that contains the camera, or \"parallel\".")
      .field("camera_from_world", &Truth::camera_from_world, "The true Pose by image name.")
      .representation([](const Truth& truth) {
        return truth.model + ", " + std::to_string(truth.camera_from_world.size()) + " poses";
      })
      .def(py::init([](const Camera& camera, std::map<std::string, Pose> poses) {
             return Truth{camera, smallest_model(camera), std::move(poses), {}, {}};
           }),
           py::arg("camera"), py::arg("camera_from_world") = std::map<std::string, Pose>());
}

}  // namespace

void bind_dataset(py::module_& m) {
  bind_truth(m);
  Record<Dataset>(m, "Dataset",
                  "What is calibrated: boards that are rigid in one world, and the views of one "
                  "camera. It does not change; make another one from its parts.")
      .field("size", &Dataset::image_size, "(width, height) of the pictures.")
      .field("target", &Dataset::boards, "The boards, and their places in the world.")
      .field("views", &Dataset::views, "The corners that each picture shows.")
      .field("truth", &Dataset::truth, "The true camera and poses, if they are known.")
      .representation(&dataset_text)
      .def(py::init(&dataset_of), py::arg("size"), py::arg("target"),
           py::arg("views") = std::vector<View>(), py::arg("truth") = py::none(),
           "From the size of the pictures (width, height), a target and its views, as `detect` "
           "returns them.")
      .def_static(
          "from_points", &dataset_from_points, py::arg("object_points"), py::arg("image_points"),
          py::arg("size"), py::arg("images") = std::vector<std::string>(),
          "From lists as cv2.calibrateCamera takes them: for each view the points (N, 3) "
          "that it shows, metres, and their pixels (N, 2), inside the image; (N, 1, 3) and (N, "
          "1, 2) too. "
          "One array (N, 3) of points counts for all views. All points together become "
          "one board. `images`: names of the views, for messages.")
      .def("to_points", &lists_of,
           "The way back: a list of points (N, 3), in world coordinates, and one of pixels (N, "
           "2), an array for each view.")
      .def("__len__", [](const Dataset& dataset) { return dataset.views.size(); });
}

}  // namespace tagcal::python
