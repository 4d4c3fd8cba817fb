#include "tagcal/scene/render.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <variant>

#include "python/arrays.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "python/scene_parts.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal::python {
namespace {

// One view of a scene.
struct SceneView {
  Scene scene;
  Pose camera_from_world;
};

SceneView view_of_scene(const MovingScene& scene, int view, std::uint64_t seed) {
  check_view(scene, view);
  SceneView result{scene_in_view(scene, view), {}};
  const ImageSize& size = result.scene.camera.image_size;
  check_pixel_count(size.width, size.height);
  result.camera_from_world = camera_poses(scene, seed)[static_cast<std::size_t>(view)];
  return result;
}

ImageF light_of(const SceneView& view) {
  return render_light(view.scene, tag_families(view.scene.boards), view.camera_from_world);
}

std::variant<Image8, Image16> picture_of_view(const MovingScene& scene, int view,
                                              std::uint64_t seed) {
  const SceneView in_view = view_of_scene(scene, view, seed);
  const ImageF light = light_of(in_view);
  const std::uint64_t noise = noise_seed(seed, view);
  if (in_view.scene.sensor.bits == 16) return expose16(light, in_view.scene.sensor, noise);
  return expose(light, in_view.scene.sensor, noise);
}

// As a variant, so that the types of Python name both.
std::variant<py::array_t<std::uint8_t>, py::array_t<std::uint16_t>> render(const MovingScene& scene,
                                                                           int view,
                                                                           std::uint64_t seed) {
  std::variant<Image8, Image16> picture;
  {
    py::gil_scoped_release release;
    picture = picture_of_view(scene, view, seed);
  }
  if (const auto* wide = std::get_if<Image16>(&picture))
    return py::array_t<std::uint16_t>(array_of(*wide));
  return py::array_t<std::uint8_t>(array_of(std::get<Image8>(picture)));
}

py::array_t<float> light(const MovingScene& scene, int view, std::uint64_t seed) {
  ImageF image;
  {
    py::gil_scoped_release release;
    image = light_of(view_of_scene(scene, view, seed));
  }
  return array_of(image);
}

py::array_t<float> depth(const MovingScene& scene, int view, std::uint64_t seed) {
  ImageF image;
  {
    py::gil_scoped_release release;
    const SceneView in_view = view_of_scene(scene, view, seed);
    image = render_depth(in_view.scene, in_view.camera_from_world);
  }
  return array_of(image);
}

View corners_of_view(const MovingScene& scene, int view, std::uint64_t seed) {
  py::gil_scoped_release release;
  const SceneView in_view = view_of_scene(scene, view, seed);
  return {image_name(view), visible_corners(in_view.scene, in_view.camera_from_world)};
}

std::vector<Pose> poses_of_scene(const MovingScene& scene, std::uint64_t seed) {
  py::gil_scoped_release release;
  return camera_poses(scene, seed);
}

Dataset dataset_of_scene(const MovingScene& scene, std::uint64_t seed) {
  std::vector<std::string> warnings;
  Dataset dataset;
  {
    py::gil_scoped_release release;
    dataset = exact_dataset(scene, camera_poses(scene, seed), &warnings);
  }
  for (const std::string& warning : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  return dataset;
}

}  // namespace

void bind_render(py::module_& m) {
  m.def("render", &render, py::arg("scene"), py::arg("view") = 0, py::arg("seed") = 0,
        "The picture of one view, (height, width), uint8, or uint16 if the sensor has 16 bits: the "
        "same bytes as `tagcal render --seed`. Each pixel has the exact area of what it sees. The "
        "GIL is released: threads render views side by side.");
  m.def("render_light", &light, py::arg("scene"), py::arg("view") = 0, py::arg("seed") = 0,
        "The light on the sensor before gamma, noise and rounding, (height, width), float32: "
        "levels in [0, 1] times the exposure.");
  m.def("render_depth", &depth, py::arg("scene"), py::arg("view") = 0, py::arg("seed") = 0,
        "The depth of what the centre of each pixel sees: z in the camera, metres, (height, "
        "width), float32; NaN for nothing.");
  m.def("visible_corners", &corners_of_view, py::arg("scene"), py::arg("view") = 0,
        py::arg("seed") = 0,
        "The exact corners that a view shows: inside the image, on a face turned to the camera, "
        "and not hidden.");
  m.def("camera_poses", &poses_of_scene, py::arg("scene"), py::arg("seed") = 0,
        "camera_from_world of all views. `seed`: of the jitter of the path, if it has any.");
  m.def("exact_dataset", &dataset_of_scene, py::arg("scene"), py::arg("seed") = 0,
        "The data set of a scene: its boards, their exact corners in all views, and the truth. "
        "Warns of boards that move relative to the first one, which are left out.");
}

}  // namespace tagcal::python
