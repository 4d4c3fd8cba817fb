#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>

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

// Points, lines, planes and conics in homogeneous coordinates: what lies on what, what meets where,
// and the projective map that is fixed by matched points (Hartley & Zisserman 2004, chapters 2 and
// 3).
//
// A point of space is (x, y, z, w), at infinity in direction (x, y, z) for w = 0; a plane is (n, d)
// with n . x + d w = 0. The plane through three points and the point of three planes are the same
// formula. The results have length 1; throws Error if the three do not determine one.
Eigen::Vector4d join(const Eigen::Vector4d& a, const Eigen::Vector4d& b, const Eigen::Vector4d& c);
Eigen::Vector4d meet(const Eigen::Vector4d& p, const Eigen::Vector4d& q, const Eigen::Vector4d& r);

// The line of two planes: its first point is the nearest to the origin, the second 1 m from it
// along n_p x n_q. Throws Error if the planes are parallel.
Line meet(const Eigen::Vector4d& p, const Eigen::Vector4d& q);

// The plane through a line and a point, and the point of a line and a plane (w = 0 if parallel).
// Throws Error if one lies in the other.
Eigen::Vector4d join(const Line& line, const Eigen::Vector4d& point);
Eigen::Vector4d meet(const Line& line, const Eigen::Vector4d& plane);

// Where a line a + t (b - a) meets a plane W + u U + v V, by the 3x3 inverse. No value if it is
// parallel to the plane, to within 1e-12, or if U and V are.
struct LineInPlane {
  double t = 0;
  double u = 0;
  double v = 0;
};
std::optional<LineInPlane> meeting(const Line& line, const Eigen::Vector3d& w,
                                   const Eigen::Vector3d& u, const Eigen::Vector3d& v);

// The 4x4 that takes five points to five points, no four of either in a plane, up to scale: its 16
// numbers are fixed by 5 x 3 equations. Throws Error if four are in a plane.
using FivePoints = std::array<Eigen::Vector4d, 5>;
Eigen::Matrix4d projective_map(const FivePoints& source, const FivePoints& target);

// A line a x + b y + c w = 0 of the plane is (a, b, c). A conic
// a x^2 + b x y + c y^2 + d x w + e y w + f w^2 = 0 is a symmetric matrix C, x' C x = 0.
Eigen::Matrix3d conic(double a, double b, double c, double d, double e, double f);

// Transforms them by the map H of points: l' = H^-T l, C' = H^-T C H^-1. Throws
// Error if H has no inverse.
Eigen::Vector3d transformed_line(const Eigen::Matrix3d& target_from_source,
                                 const Eigen::Vector3d& line_in_source);
Eigen::Matrix3d transformed_conic(const Eigen::Matrix3d& target_from_source,
                                  const Eigen::Matrix3d& conic_in_source);

// The plane of all points that a projection P (3 x 4) maps to an image line, P' l, and the cone of
// those that it maps to a conic, P' C P.
using Projection34 = Eigen::Matrix<double, 3, 4>;
Eigen::Vector4d plane_of_image_line(const Projection34& projection, const Eigen::Vector3d& line);
Eigen::Matrix4d cone_of_image_conic(const Projection34& projection, const Eigen::Matrix3d& conic);

}  // namespace tagcal
