#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "tagcal/geometry/pose.hpp"

// The elementary transforms from object to world, applied to points, lines and planes.
//
// Vectors are columns and transforms stand on their left: in A * B * x, B acts first. Books with
// row vectors write x' = x M with the first transform leftmost: their M is our transpose, and their
// product M1 M2 is our (A2 * A1), A_i = M_i transposed.
//
// A rigid transform is a Pose, one that stretches or shears is an Affine; they compose with each
// other by *, have a 4x4 .matrix() and map a point by `transform * x`. All functions throw Error on
// a number that is not finite. Angles in radians, right-handed: rotation_about_z(pi / 2) takes x to
// y.

namespace tagcal {

// x -> linear() x + translation(). Unaligned, as every matrix in a public struct.
using Affine = Eigen::Transform<double, 3, Eigen::Affine, Eigen::DontAlign>;

enum class Axis { x, y, z };

Pose translation(const Eigen::Vector3d& offset);

Pose rotation_about_x(double angle_rad);
Pose rotation_about_y(double angle_rad);
Pose rotation_about_z(double angle_rad);

// Rotations about an axis through the origin (Rodrigues 1840) and about the line through a point
// along an axis. The axis may have any length except zero, for which they throw Error.
Pose rotation_about_axis(const Eigen::Vector3d& axis, double angle_rad);
Pose rotation_about_line(const Eigen::Vector3d& point, const Eigen::Vector3d& axis,
                         double angle_rad);

// Scales along the axes, about the origin. A factor may be negative (a mirror) or zero (a shadow).
Affine scaling(const Eigen::Vector3d& factors);
Affine scaling(double factor);

// Adds factor times the coordinate `by` to the coordinate `along`. Throws Error if they are equal.
Affine shearing(Axis along, Axis by, double factor);

Affine affine(const Pose& pose);

// The affine transform as a pose. Throws Error if it stretches, shears or mirrors: |L'L - 1| of its
// linear part L above 1e-9.
Pose rigid(const Affine& transform);

inline Affine operator*(const Pose& a_from_b, const Affine& b_from_c) {
  return affine(a_from_b) * b_from_c;
}
inline Affine operator*(const Affine& a_from_b, const Pose& b_from_c) {
  return a_from_b * affine(b_from_c);
}

// Throws Error if there is no inverse: a pivot of the linear part below 1e-12 of the largest.
Affine inverse_of(const Affine& transform);

// Two rotations that take an axis to x. With R the one or the other, R^-1 rotation_about_x(a) R is
// rotation_about_axis(axis, a); they differ by a rotation about x. The first turns about x until
// the axis has z = 0, then about z. The second has the rows axis, axis x `across`, and the cross
// product of these two, all of unit length. Both throw Error for an axis of
// length zero, the second also where `across` is parallel to it (to within 1e-9 rad).
Pose aligning_with_x(const Eigen::Vector3d& axis);
Pose aligning_with_x(const Eigen::Vector3d& axis, const Eigen::Vector3d& across);

// Polar coordinates of the plane: rho from the origin, theta from +x towards +y.
struct Polar {
  double rho = 0;
  double theta_rad = 0;
};
Polar polar_from_cartesian(const Eigen::Vector2d& x);
Eigen::Vector2d cartesian_from_polar(const Polar& polar);

// Polar coordinates of space: rho from the origin, theta from +z (0 to pi), phi about z from +x
// towards +y: x = (rho sin theta cos phi, rho sin theta sin phi, rho cos theta). Those from
// Cartesian coordinates have rho >= 0 and phi in (-pi, pi]; an undetermined angle (phi on the z
// axis, theta at the origin) is 0.
struct Spherical {
  double rho = 0;
  double theta_rad = 0;
  double phi_rad = 0;
};
Spherical spherical_from_cartesian(const Eigen::Vector3d& x);
Eigen::Vector3d cartesian_from_spherical(const Spherical& spherical);

// The matrix of the signed minors: det(M) M^-T, which exists for a singular M too. The 3x3 takes
// u x v to (M u) x (M v), so it transforms normals; the 4x4 transforms planes if M transforms
// points.
Eigen::Matrix3d cofactor_matrix(const Eigen::Matrix3d& matrix);
Eigen::Matrix4d cofactor_matrix(const Eigen::Matrix4d& matrix);

// A plane is (n, d) with n . x + d = 0. If M (affine or projective) transforms points, its inverse
// transpose transforms planes. The cofactors replace the inverse, so that M may be singular: such
// an M takes every plane that has an image to the same plane. The result has |n| = 1, and n . x + d
// keeps its sign unless M is singular. Throws Error if the plane has no image: its normal is zero,
// M flattens it to a line, or M takes it to infinity.
Eigen::Vector4d transformed_plane(const Eigen::Matrix4d& target_from_source,
                                  const Eigen::Vector4d& plane_in_source);

// Transforms a line, given by two of its points. Throws Error if they coincide before or after.
struct Line {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::UnitX();
};
Line transformed_line(const Affine& target_from_source, const Line& line_in_source);

}  // namespace tagcal
