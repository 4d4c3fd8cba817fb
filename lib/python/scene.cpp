#include <pybind11/pybind11.h>

#include "python/bindings.hpp"
#include "python/records.hpp"
#include "tagcal/scene/moving_scene.hpp"

namespace tagcal::python {
namespace {

std::string scene_text(const MovingScene& scene) {
  const ImageSize& size = scene.settings.camera.image_size;
  const std::size_t boards = scene.boards.size();
  return std::to_string(boards) + (boards == 1 ? " board, " : " boards, ") +
         std::to_string(scene.settings.num_views) + " views of " + std::to_string(size.width) +
         " x " + std::to_string(size.height);
}

}  // namespace

void bind_scene(py::module_& m) {
  Record<MovingScene>(m, "Scene", "What pictures are rendered of: boards, occluders, a camera.")
      .representation(&scene_text)
      .def(
          "__len__", [](const MovingScene& scene) { return scene.settings.num_views; },
          "The number of views.");
}

}  // namespace tagcal::python
