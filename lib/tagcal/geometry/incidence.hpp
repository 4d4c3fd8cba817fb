#pragma once

#include <array>
#include <optional>

#include "tagcal/geometry/transform.hpp"

// Points, lines, planes and conics in homogeneous coordinates: what lies on what, what meets where,
// and the projective map that is fixed by matched points (Hartley & Zisserman 2004, chapters 2
// and 3). All functions throw Error on numbers that are not finite.

namespace tagcal {

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
