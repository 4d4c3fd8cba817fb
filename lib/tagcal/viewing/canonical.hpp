#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "tagcal/camera/camera.hpp"

// View volumes, their transforms to the canonical volume, and the matrices that make a renderer
// draw what a calibrated camera sees. All coordinates are in OpenGL's eye axes: x right, y up,
// looking along -z, so that points in front have z < 0 (geometry/viewpoint.hpp converts from OpenCV
// axes). Near and far are distances in metres.

namespace tagcal {

// An axis-parallel rectangle: left < right, bottom < top.
struct Window {
  double left = -1;
  double right = 1;
  double bottom = -1;
  double top = 1;
};

enum class Projection { perspective, parallel };

// The visible space between the planes z = -near and z = -far: a frustum through the window, which
// lies in the near plane, or the box behind the window. Far may be infinity for a perspective.
struct ViewVolume {
  Projection projection = Projection::perspective;
  Window window;
  double near_m = 0.1;
  double far_m = 100;
};

// A frustum about the axis. aspect = width / height. Domain: 0 < field of view < pi, else Error.
ViewVolume symmetric_frustum(double vertical_field_of_view_rad, double aspect, double near_m,
                             double far_m);

// The corners of a volume with finite far: those of the near plane first, each plane
// counter-clockwise from (left, bottom).
std::vector<Eigen::Vector3d> corners(const ViewVolume& volume);

// x and y are in [-1, 1]. OpenGL: z in [-1, 1], near at -1. PHIGS: z in [0, -1], near at 0. From
// zero to one, as in Direct3D and Vulkan: near at 0; from one to zero ("reversed z"): near at 1, so
// that the steps of floating-point numbers, fine near 0, make up for those of 1 / z, fine near the
// eye.
enum class CanonicalVolume { opengl, phigs, zero_to_one, one_to_zero };

// One step of the transform from eye to clip coordinates.
struct NormalisingStep {
  std::string_view name;
  Eigen::Matrix4d matrix;
};

// The steps in the order of application, for a finite far. Perspective: shear the window's centre
// onto the axis, scale the sides to 45 degrees and far to z = -1, map the pyramid to a box.
// Parallel: move the window's centre to the origin, scale. Then z' = -2 z - w for OpenGL, -z for
// zero_to_one, z + w for one_to_zero.
std::vector<NormalisingStep> normalising_steps(const ViewVolume& volume, CanonicalVolume canonical);

// The product of the steps, scaled to w = -z for a perspective and w = 1 otherwise. For
// CanonicalVolume::opengl it is the matrix of glFrustum or glOrtho. Throws Error unless near < far,
// near > 0 for a perspective, left < right and bottom < top.
Eigen::Matrix4d clip_from_eye(const ViewVolume& volume,
                              CanonicalVolume canonical = CanonicalVolume::opengl);

// Depth in the PHIGS volume of a perspective with k = near / far: d in [0, -1] from z in [-k, -1]
// (the eye's z divided by far; negative in front), and back. 1/z is linear in d: planes stay
// planes, the order of depths is kept, and the resolution is finest near the eye.
//   d = -(1 + k / z) / (1 - k)      z = -k / (1 + (1 - k) d)
double phigs_depth(double z, double k);
double z_from_phigs_depth(double depth, double k);

// OpenGL's depth in [-1, 1] at the eye's z < 0 of a perspective, and back; far may be infinity.
double opengl_depth(double z_in_eye_m, double near_m, double far_m);
double z_from_opengl_depth(double depth, double near_m, double far_m);

// The smallest difference in z that a depth buffer with this number of bits resolves at the eye's
// z: z^2 (f - n) / (f n) / (2^bits - 1), to first order.
double depth_resolution_m(double z_in_eye_m, double near_m, double far_m, int bits);

// The view volume of a calibrated camera: the off-centre frustum (or box, for a Parallel lens)
// whose window is the outer border of its pixels. Throws Error for a fisheye and for a lens with
// distortion, because no matrix can represent them: render without distortion (undistorted() in
// viewing/viewport.hpp), then distort the picture.
ViewVolume view_volume(const Camera& camera, double near_m, double far_m);

// A camera and its near and far planes.
struct CameraFromMatrix {
  Camera camera;
  double near_m = 0;
  double far_m = 0;  // may be infinity
};

// Recovers the camera from the matrix of a renderer that follows OpenGL's definitions, such as
// clip_from_eye(view_volume(...)), at any scale. Throws Error with the wrong entry if the matrix
// has another form (skew, a rotated or flipped image, no depth).
CameraFromMatrix camera_from_opengl(const Eigen::Matrix4d& clip_from_eye, const ImageSize& size);

}  // namespace tagcal
