#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "tagcal/camera/lens.hpp"

// The classic planar projections of a drawing, as 4x4 matrices on homogeneous columns (Foley, van
// Dam, Feiner & Hughes, Computer Graphics, section 6.4), and the named views of technical drawing.
// All in camera axes: x right, y down, z forward, lengths in metres. The image of a point is what
// divided() gives, a point in the plane of projection.

namespace tagcal {

// Perspective with the centre at the origin onto the plane z = d:
// (x, y, z) -> (d x / z, d y / z, d). d > 0 and finite, else Error.
Eigen::Matrix4d perspective_from_origin(double d_m);

// (x, y, z) -> (x / z, y / z, 1 / z): planes stay planes, and 1 / z keeps the order of depths.
Eigen::Matrix4d perspective_map();

// Perspective with the centre at (0, 0, -d) onto the plane z = 0:
// (x, y, z) -> (x / (z/d + 1), y / (z/d + 1), 0). The same picture as from the origin, of a world
// moved by d. d > 0, else Error; at d = infinity it is the orthographic projection.
Eigen::Matrix4d perspective_from_behind(double d_m);

// Along z onto the plane z = 0: (x, y, z) -> (x, y, 0).
Eigen::Matrix4d orthographic_projection();

// Along any direction onto the plane z = 0: x -> x - (z / d_z) d. Throws Error for a direction in
// that plane.
Eigen::Matrix4d oblique_projection(const Eigen::Vector3d& direction);

// The oblique projections with a name. `angle_rad` is the direction in which depth recedes in the
// drawing, from x right, counter-clockwise as seen: (0, 0, 1), a metre further away, is drawn at
// l (cos, -sin) of it. Cavalier: rays at 45 degrees to the plane, l = 1, depth keeps its length.
// Cabinet: rays at arctan 2 (63.4 degrees), l = 1/2.
Eigen::Matrix4d cavalier_projection(double angle_rad);
Eigen::Matrix4d cabinet_projection(double angle_rad);

// The step from homogeneous to Cartesian coordinates: x / w. No value unless w > 0: a point with
// w = 0 is at infinity or in the plane of the centre, one with w < 0 is behind the centre and would
// be seen mirrored.
std::optional<Eigen::Vector3d> divided(const Eigen::Vector4d& homogeneous);

// The views of technical drawing, of a world with z up: the rotation camera_from_world, for
// orthographic_projection() or a Parallel lens.
enum class DrawnView {
  plan,             // from above: x right, y up on the page
  front_elevation,  // looking along +y: x right, z up
  side_elevation,   // from the right, looking along -x: y right, z up
  isometric,        // from (1, -1, 1): axes 120 degrees apart on the page, drawn at sqrt(2/3)
};
Eigen::Quaterniond camera_from_world_drawn(DrawnView view);

// The vanishing points of all lines along a direction (camera frame, either sign, not zero). A
// perspective has one, unless the direction is parallel to the image plane (to within 1e-12 of its
// length) or outside of the lens' domain; a fisheye has up to two, one for each sign; parallel rays
// have none.
std::vector<Eigen::Vector2d> vanishing_points(const Lens& lens,
                                              const Eigen::Vector3d& direction_in_camera);

// The number of the world's axes with a vanishing point: 1, 2 or 3 for the one-, two- and
// three-point perspective of a pinhole.
int num_vanishing_axes(const Lens& lens, const Eigen::Quaterniond& camera_from_world);

}  // namespace tagcal
