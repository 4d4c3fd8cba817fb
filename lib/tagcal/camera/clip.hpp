#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/camera/lens.hpp"

namespace tagcal {

// The side of a plane that is kept: normal . x >= offset.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset = 0;
};

// The part of a convex polygon on the kept side (Sutherland & Hodgman, CACM 1974); fewer than three
// corners where there is none. An edge is cut at the same point whichever way it runs.
std::vector<Eigen::Vector3d> clip_polygon(const std::vector<Eigen::Vector3d>& polygon,
                                          const HalfSpace& kept);

// The part of a convex polygon, in the camera frame, that a lens can project, by flat cuts: in
// front of `near_m` for a perspective, and within 256 planes inscribed in the lens' cone where that
// is convex. A fisheye beyond 90 degrees is not: there a polygon is kept only if all of it is
// inside.
std::vector<Eigen::Vector3d> clip_to_domain(const std::vector<Eigen::Vector3d>& polygon,
                                            const Lens& lens, double near_m);

}  // namespace tagcal
