#pragma once

#include <pybind11/pybind11.h>

#include "tagcal/scene/moving_scene.hpp"

namespace tagcal::python {

// A level of grey, 0 to 1. Throws Error for others.
double level(double value, const char* name);

// The view of a scene: its number, and the scene as it stands then. Throws Error for a number that
// the scene does not have.
void check_view(const MovingScene& scene, int view);

// Parts of bind_scene: Sensor, Occluder, the lamps and Light; functions that render; poses.
void bind_scene_parts(pybind11::module_& m);
void bind_render(pybind11::module_& m);
void bind_paths(pybind11::module_& m);

}  // namespace tagcal::python
