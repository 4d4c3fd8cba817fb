#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <numbers>

#include "python/arrays.hpp"
#include "python/records.hpp"
#include "python/scene_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/scene_file.hpp"

// Poses of many views, for a Scene.

namespace tagcal::python {
namespace {

double finite(double value, const char* name) {
  if (!std::isfinite(value))
    throw Error(std::string(name) + ": must be finite, got " + number(value));
  return value;
}

struct Jitter {
  double position_m, target_m, roll_rad;
  std::uint64_t seed;
};

std::vector<Pose> poses_on(CameraPath path, int views, const Jitter& jitter) {
  if (views < 1 || views > scene_limits().views)
    throw Error("views: must be 1 to " + std::to_string(scene_limits().views) + ", got " +
                std::to_string(views));
  Scene scene;
  scene.path = std::move(path);
  scene.num_views = views;
  scene.jitter = {not_negative(jitter.position_m, "position_jitter_m"),
                  not_negative(jitter.target_m, "target_jitter_m"),
                  not_negative(jitter.roll_rad, "roll_jitter_rad")};
  py::gil_scoped_release release;
  return camera_poses(scene, jitter.seed);
}

std::vector<Pose> poses_on_ring(int views, double radius_m, const ArrayLike& centre,
                                const ArrayLike& target, double start_rad, double end_rad,
                                double position_jitter_m, double target_jitter_m,
                                double roll_jitter_rad, std::uint64_t seed) {
  return poses_on(RingPath{vector3(centre, "centre"), positive(radius_m, "radius_m"),
                           finite(start_rad, "start_rad"), finite(end_rad, "end_rad"),
                           vector3(target, "target")},
                  views, {position_jitter_m, target_jitter_m, roll_jitter_rad, seed});
}

void check_order(double low, double high, const char* name_low, const char* name_high) {
  if (low > high)
    throw Error(std::string(name_low) + ": must not be above " + name_high + ", " + number(high) +
                ", got " + number(low));
}

std::vector<Pose> poses_on_dome(int views, double min_distance_m, double max_distance_m,
                                const ArrayLike& target, double min_elevation_rad,
                                double max_elevation_rad, double min_azimuth_rad,
                                double max_azimuth_rad, double position_jitter_m,
                                double target_jitter_m, double roll_jitter_rad,
                                std::uint64_t seed) {
  constexpr double kUp = std::numbers::pi / 2;
  check_order(positive(min_distance_m, "min_distance_m"),
              positive(max_distance_m, "max_distance_m"), "min_distance_m", "max_distance_m");
  check_order(finite(min_azimuth_rad, "min_azimuth_rad"),
              finite(max_azimuth_rad, "max_azimuth_rad"), "min_azimuth_rad", "max_azimuth_rad");
  check_order(min_elevation_rad, max_elevation_rad, "min_elevation_rad", "max_elevation_rad");
  if (!(min_elevation_rad >= -kUp && max_elevation_rad <= kUp))
    throw Error("min_elevation_rad, max_elevation_rad: must be in -pi/2..pi/2, got " +
                number(min_elevation_rad) + " and " + number(max_elevation_rad));
  return poses_on(DomePath{vector3(target, "target"), min_distance_m, max_distance_m,
                           min_azimuth_rad, max_azimuth_rad, min_elevation_rad, max_elevation_rad},
                  views, {position_jitter_m, target_jitter_m, roll_jitter_rad, seed});
}

std::vector<Pose> poses_on_line(int views, const ArrayLike& start, const ArrayLike& end,
                                const ArrayLike& target, double position_jitter_m,
                                double target_jitter_m, double roll_jitter_rad,
                                std::uint64_t seed) {
  return poses_on(LinePath{vector3(start, "start"), vector3(end, "end"), vector3(target, "target")},
                  views, {position_jitter_m, target_jitter_m, roll_jitter_rad, seed});
}

}  // namespace

void bind_paths(py::module_& m) {
  const std::vector<double> origin = {0, 0, 0};
  m.def("poses_on_ring", &poses_on_ring, py::arg("views"), py::arg("radius_m"),
        py::arg("centre") = origin, py::arg("target") = origin, py::arg("start_rad") = 0.0,
        py::arg("end_rad") = 2 * std::numbers::pi, py::arg("position_jitter_m") = 0.0,
        py::arg("target_jitter_m") = 0.0, py::arg("roll_jitter_rad") = 0.0, py::arg("seed") = 0,
        "camera_from_world of `views` cameras on a circle about `centre` (3,), in a plane of "
        "constant z, which look at `target` (3,), image upright. Each is displaced at random, "
        "uniformly, by the jitter at most. A full turn omits the repeated view.");
  m.def("poses_on_dome", &poses_on_dome, py::arg("views"), py::arg("min_distance_m"),
        py::arg("max_distance_m"), py::arg("target") = origin, py::arg("min_elevation_rad") = 0.0,
        py::arg("max_elevation_rad") = std::numbers::pi / 2, py::arg("min_azimuth_rad") = 0.0,
        py::arg("max_azimuth_rad") = 2 * std::numbers::pi, py::arg("position_jitter_m") = 0.0,
        py::arg("target_jitter_m") = 0.0, py::arg("roll_jitter_rad") = 0.0, py::arg("seed") = 0,
        "The same for cameras spread evenly over a part of a sphere about `target`, at distances "
        "that grow evenly: azimuth from +x towards +y, elevation above the world's xy-plane.");
  m.def("poses_on_line", &poses_on_line, py::arg("views"), py::arg("start"), py::arg("end"),
        py::arg("target") = origin, py::arg("position_jitter_m") = 0.0,
        py::arg("target_jitter_m") = 0.0, py::arg("roll_jitter_rad") = 0.0, py::arg("seed") = 0,
        "The same for cameras on a line from `start` to `end`, both (3,), metres.");
}

}  // namespace tagcal::python
