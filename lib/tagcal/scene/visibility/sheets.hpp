#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tagcal/scene/print/board_ink.hpp"
#include "tagcal/scene/scene.hpp"

// Visibility in a scene; the exact corners and the renderer share it, so that they agree.

namespace tagcal::internal {

// The eye in homogeneous world coordinates: a point (w = 1), or for parallel rays the direction
// opposite to them (w = 0). The ray from a point x to the eye runs along position - w x.
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

// All opaque surfaces: papers, then occluders. Throws Error if an occluder has fewer than three
// corners or no area.
std::vector<Sheet> sheets(const Scene& scene);

// Returns true if the front of the sheet is turned to the eye.
bool faces(const Sheet& sheet, const Eye& eye);

// The first surface that a ray (world coordinates) hits. No value if it hits none. Surfaces on
// which the ray begins, or along which it runs, do not count.
struct Hit {
  std::size_t sheet = 0;  // index
  double distance = 0;    // along the ray, in lengths of its direction
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};
std::optional<Hit> nearest_hit(const std::vector<Sheet>& sheets, const Ray& ray);

// Returns true if the sheet lies between the eye and a point x off the sheet, in world coordinates.
bool hides(const Sheet& sheet, const Eye& eye, const Eigen::Vector3d& x);

// The order of painting, as indices from back to front. Exact if of any two sheets one lies wholly
// on one side of the other's plane; sheets that intersect, or hide each other in a cycle, are
// ordered by the distance of their middles.
std::vector<std::size_t> painting_order(const std::vector<Sheet>& sheets, const Eye& eye);

}  // namespace tagcal::internal
