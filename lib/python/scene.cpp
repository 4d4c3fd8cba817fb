#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/bindings.hpp"
#include "python/boards.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "python/scene_parts.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal::python {

template <>
inline constexpr bool kHasNoState<MovingScene> = true;  // its paths are functions

void check_view(const MovingScene& scene, int view) {
  if (view < 0 || view >= scene.settings.num_views)
    throw Error("view: must be in 0.." + std::to_string(scene.settings.num_views - 1) + ", got " +
                std::to_string(view));
}

namespace {

struct Levels {
  double background, paper, ink;
};

Scene still_scene(const Camera& camera, const PosesLike& poses, const Sensor& sensor,
                  const Levels& levels, const std::optional<Light>& light) {
  try {
    check_pixel_count(camera.image_size.width, camera.image_size.height);
  } catch (const Error& error) {
    throw Error(std::string("camera: its image ") + error.what());
  }
  check_sensor(camera, sensor);
  ExplicitPath path{poses_of(poses, "camera_from_world")};
  if (path.camera_from_world.empty()) throw Error("camera_from_world: must have a pose");
  Scene scene;
  scene.camera = camera;
  scene.model = smallest_model(camera);
  scene.num_views = static_cast<int>(path.camera_from_world.size());
  scene.path = std::move(path);
  scene.sensor = sensor;
  scene.background_level = level(levels.background, "background_level");
  scene.paper_level = level(levels.paper, "paper_level");
  scene.ink_level = level(levels.ink, "ink_level");
  scene.light = light;
  return scene;
}

MovingScene scene_of(const Camera& camera, const TargetLike& target, const PosesLike& poses,
                     const std::optional<Sensor>& sensor, const std::vector<Occluder>& occluders,
                     const std::optional<Light>& light, double background_level, double paper_level,
                     double ink_level, double ink_spread_m, double paper_margin_m,
                     double print_grid_m) {
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  MovingScene scene;
  scene.settings = still_scene(camera, poses, sensor.value_or(Sensor()),
                               {background_level, paper_level, ink_level}, light);
  scene.settings.paper_margin_m = not_negative(paper_margin_m, "paper_margin_m");
  if (!(ink_spread_m <= paper_margin_m) || !std::isfinite(ink_spread_m))
    throw Error("ink_spread_m: must not be above paper_margin_m, got " + number(ink_spread_m));
  scene.settings.ink_spread_m = ink_spread_m;
  scene.settings.print_grid_m = not_negative(print_grid_m, "print_grid_m");
  for (const PlacedBoard& board : boards) scene.boards.push_back({kWorldFrame, board});
  for (const Occluder& occluder : occluders) scene.occluders.push_back({kWorldFrame, occluder});
  return scene;
}

std::string scene_text(const MovingScene& scene) {
  const ImageSize& size = scene.settings.camera.image_size;
  std::string text = counted(scene.boards.size(), "board");
  if (!scene.occluders.empty()) text += ", " + counted(scene.occluders.size(), "occluder");
  return text + ", " + counted(static_cast<std::size_t>(scene.settings.num_views), "view") +
         " of " + size_text(size) + (moves(scene) ? ", moving" : "");
}

std::vector<PlacedBoard> target_in_view(const MovingScene& scene, int view) {
  check_view(scene, view);
  return scene_in_view(scene, view).boards;
}

std::vector<Occluder> occluders_in_view(const MovingScene& scene, int view) {
  check_view(scene, view);
  return scene_in_view(scene, view).occluders;
}

Camera camera_in_view(const MovingScene& scene, int view) {
  check_view(scene, view);
  return scene_in_view(scene, view).camera;
}

void define_state(py::class_<MovingScene>& scene) {
  scene
      .def_property_readonly(
          "camera", [](const MovingScene& s) { return camera_in_view(s, 0); },
          "The camera; in a scene that moves it is that of the first view.")
      .def_property_readonly(
          "target", [](const MovingScene& s) { return target_in_view(s, 0); },
          "The boards in the world, for `detect` and others; those of the first view.")
      .def_property_readonly(
          "sensor", [](const MovingScene& s) { return s.settings.sensor; }, "Its sensor.")
      .def_property_readonly(
          "light", [](const MovingScene& s) { return s.settings.light; },
          "The light on the sheets, or None: they have their own levels.")
      .def_property_readonly(
          "moves", [](const MovingScene& s) { return moves(s); },
          "True if boards, occluders or the lens differ from view to view.")
      .def("camera_in_view", &camera_in_view, py::arg("view"), "The camera of a view.")
      .def("target_in_view", &target_in_view, py::arg("view"), "The boards as they stand then.")
      .def("occluders_in_view", &occluders_in_view, py::arg("view"),
           "The occluders as they stand then.")
      .def(
          "__len__", [](const MovingScene& s) { return s.settings.num_views; },
          "The number of views.");
}

}  // namespace

void bind_scene(py::module_& m) {
  bind_scene_parts(m);
  Record<MovingScene> scene(m, "Scene",
                            "What pictures are rendered of: a camera and its poses, boards, "
                            "occluders, light.");
  scene.representation(&scene_text)
      .def(
          py::init(&scene_of), py::arg("camera"), py::arg("target"), py::arg("camera_from_world"),
          py::arg("sensor") = py::none(), py::arg("occluders") = std::vector<Occluder>(),
          py::arg("light") = py::none(), py::arg("background_level") = 0.5,
          py::arg("paper_level") = 0.9, py::arg("ink_level") = 0.1, py::arg("ink_spread_m") = 0.0,
          py::arg("paper_margin_m") = 0.02, py::arg("print_grid_m") = 0.0,
          "`camera_from_world`: a pose for each view: a Pose, a list of these, or (N, 4, 4). "
          "Levels are grey, 0 to 1. `ink_spread_m`: the print has grown into the white at each "
          "edge. `paper_margin_m`: white paper around the tags. `print_grid_m`: side of a pixel of "
          "the drawing, to whole numbers of which the cells of tags are rounded.");
  define_state(scene);
  bind_render(m);
  bind_paths(m);
}

}  // namespace tagcal::python
