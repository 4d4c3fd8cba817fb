#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tagcal/scene/print/board_ink.hpp"
#include "tagcal/scene/scene.hpp"

// What hides what in a scene: shared by the exact corners and the renderer, so that they agree.

namespace tagcal::internal {

// Where rays meet: a point (w = 1), or for parallel rays the direction against them (w = 0), both
// in world coordinates. The rays from a point x to the eye run along position - w x.
struct Eye {
  Eigen::Vector3d position;
  double w = 1;

  Eigen::Vector3d towards_from(const Eigen::Vector3d& x) const { return position - w * x; }
};

Eye eye(const Lens& lens, const Pose& camera_from_world);

// A flat, convex, opaque polygon in world coordinates: the paper of a panel, or an occluder.
struct Sheet {
  std::vector<Eigen::Vector3d> corners;
  Eigen::Vector3d normal;  // unit; the corners run counter-clockwise seen from where it points
  std::size_t board = 0;   // index in the scene, of a paper
  std::size_t occluder = 0;
  std::optional<BoardPanel> panel;  // of a paper
};

// Everything that can hide something: papers, then occluders. Throws Error where an occluder has
// fewer than three corners or no area.
std::vector<Sheet> sheets(const Scene& scene);

// Whether the front of the sheet is turned to the eye.
bool faces(const Sheet& sheet, const Eye& eye);

// What a ray (world coordinates) meets first, of several surfaces; through openings between them
// too. No value where it meets none. Surfaces that the ray begins on, or runs along, do not count.
struct Hit {
  std::size_t sheet = 0;  // index
  double distance = 0;    // along the ray, in lengths of its direction
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};
std::optional<Hit> nearest_hit(const std::vector<Sheet>& sheets, const Ray& ray);

// Whether the sheet lies between the eye and a point x off the sheet, in world coordinates.
bool hides(const Sheet& sheet, const Eye& eye, const Eigen::Vector3d& x);

// The order in which to paint, indices from behind to the front. Exact where the plane of one of
// two sheets has the other wholly on one side; sheets that cut through each other, or hide each
// other in a ring, go by the distance of their middles.
std::vector<std::size_t> painting_order(const std::vector<Sheet>& sheets, const Eye& eye);

}  // namespace tagcal::internal
