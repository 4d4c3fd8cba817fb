#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "defects.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/scene.hpp"

// Random worlds: a camera, a board, its views and a sensor, each drawn from a seed and an index.

namespace tagcal {

struct World {
  WorldId id;
  Scene scene;  // with the board of the target file, flat and as designed
  Defects defects;
  // Properties that the scene was drawn with.
  double field_of_view_deg = 0;  // of the lens with its distortion, across the image
  double tag_px = 0;             // a tag's side where it faces the camera, typical of the views
  double coverage = 0;           // area of the board, facing the camera, over that of the image
  double most_tilt_deg = 0;      // between the board's normal and the line of sight
  std::string pictures;          // one of picture_kinds(); "" without the defect `camera`
  double ink_spread_px = 0;      // by which the print has grown, in a tag of that size
};

// Equal ids give equal worlds, and ids of equal seed and index the same camera, board, poses and
// sensor. Every world has a lens of the named model with a ray at every node of the image's grid,
// occluders that hide nothing of the board, and views with at least eight visible corners.
World draw_world(const WorldId& id);

// The scene as it is rendered: on a bent board each tag is a flat square of its own, in front of
// white paper. Its corners are then those of the squares, which differ from the bent surface by the
// bend within a tag. The renderer has no tags that are longer along y, and no sheared rows.
Scene real_scene(const World& world);

// The seed of the sensor's noise, as `tagcal render --seed` takes it.
inline std::uint64_t render_seed(const World& world) { return world.id.index + 1; }

// A camera of any model of the ladder but `weak`, with its name.
struct DrawnCamera {
  Camera camera;
  std::string model;
  double field_of_view_deg = 0;
};
DrawnCamera draw_camera(Random& random);

// What cameras do to their pictures in worlds with the defect `camera`: one kind a world.
std::vector<std::string> picture_kinds();

// Changes the scene's sensor, or its print, to pictures of the kind, or of one that is drawn
// uniformly from those that suit the lens if `kind` is empty. Returns the kind, "" if it does not
// suit the lens. Precondition: the scene has explicit poses and one AprilGrid.
std::string draw_pictures(const std::string& kind, Scene& scene, Random& random);

// A scene with explicit poses, of grids or tags, as a file for `tagcal render`
// (docs/reference/formats.md). Read back, it is the same to the last bit.
std::string scene_text(const Scene& scene);

}  // namespace tagcal
