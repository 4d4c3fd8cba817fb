#pragma once

#include <cstdint>

#include "tagcal/random.hpp"
#include "tagcal/scene/scene.hpp"

// Random worlds: a camera, a board, its views and a sensor, each drawn from a seed and an index.

namespace tagcal {

struct World {
  std::uint64_t seed = 0;
  std::uint64_t index = 0;
  Scene scene;
  // Properties that the scene was drawn with.
  double field_of_view_deg = 0;  // of the lens with its distortion, across the image
  double tag_px = 0;             // a tag's side where it faces the camera, typical of the views
  double coverage = 0;           // area of the board, facing the camera, over that of the image
  double most_tilt_deg = 0;      // between the board's normal and the line of sight
  double ink_spread_px = 0;      // by which the print has grown, in a tag of that size
};

// Equal seed and index give equal worlds. Every world has right data: a flat board that agrees with
// its file, a lens of the named model with a ray at every node of the image's grid, occluders
// that hide nothing of the board, and views with at least eight visible corners.
World draw_world(std::uint64_t seed, std::uint64_t index);

// The seed of the sensor's noise, as `tagcal render --seed` takes it.
inline std::uint64_t render_seed(const World& world) { return world.index + 1; }

// A camera of any model of the ladder but `weak`, with its name.
struct DrawnCamera {
  Camera camera;
  std::string model;
  double field_of_view_deg = 0;
};
DrawnCamera draw_camera(Random& random);

// Convex polygons beside and behind the board that hide no part of its paper in any view.
std::vector<Occluder> draw_occluders(const Scene& scene, Random& random);

// A number whose logarithm is uniform; low > 0.
double log_uniform(double low, double high, Random& random);

}  // namespace tagcal
