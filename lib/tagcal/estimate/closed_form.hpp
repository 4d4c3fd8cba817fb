#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/geometry/pose.hpp"

// Linear solutions, exact without noise. Image points come as rays: directions in the camera frame
// of any length but zero, (x, y, 1) for a pinhole, so that a view beyond 180 degrees is no
// exception.

namespace tagcal {

// The shape of a set of points decides which solver fits it.
enum class PointShape { point, line, plane, space };

// A set of points: its shape, centre, size, and a frame whose xy-plane is the best plane through
// it.
struct PointSpread {
  PointShape shape = PointShape::point;
  double size = 0;       // RMS distance from the centre along the longest axis, metres
  double thickness = 0;  // RMS distance from the best plane / size
  Pose plane_from_target;
};

// Below 1e-3 of the longest axis an extent counts as nothing (line, point); below 5 % of it the
// thickness counts as a plane, as a start for a solver that then uses the true points.
PointSpread spread_of(std::span<const Eigen::Vector3d> points);

// M (3 x d) with ray_i ~ M x_i for homogeneous points, the columns of x (d x n, last row 1), by the
// normalised direct linear transformation (Hartley & Zisserman 2004, section 4.1), the sign such
// that the points lie in front. Needs d = 3: four, d = 4: six points; no value where they do not
// fix M.
std::optional<Eigen::MatrixXd> projective_map(const Eigen::MatrixXd& x,
                                              std::span<const Eigen::Vector3d> rays);

// Plane to rays: H with ray_i ~ H (X_i, Y_i, 1), by the normalised direct linear transformation
// (Hartley & Zisserman 2004, algorithm 4.2), the sign such that the points lie in front. Needs four
// points or more, no three of four on a line; no value where they do not fix H.
std::optional<Eigen::Matrix3d> homography(std::span<const Eigen::Vector2d> points,
                                          std::span<const Eigen::Vector3d> rays);

// The pose of a plane (its points at z = 0) from its homography to rays of a calibrated camera
// (Zhang, PAMI 2000, section 3.1): H ~ [r1 r2 t].
Pose pose_from_homography(const Eigen::Matrix3d& camera_from_plane);

// The focal length, as a multiple of the one that the rays were made with, from homographies of one
// camera whose principal point is known: h1 and h2 are images of orthogonal directions of equal
// length (Zhang 2000, eqs. 3-4, with one unknown). No value where they do not fix it: frontal
// planes.
std::optional<double> focal_ratio_from_homographies(std::span<const Eigen::Matrix3d> homographies);

// The pose of six points or more in space, not in a plane, by the normalised direct linear
// transformation (Hartley & Zisserman 2004, algorithm 7.1) and the nearest rotation.
std::optional<Pose> pose_from_points_dlt(std::span<const Eigen::Vector3d> points,
                                         std::span<const Eigen::Vector3d> rays);

// The pose of any set of points by the solver that fits its shape; no value for a line, or where
// there are too few points (four in a plane, six in space).
std::optional<Pose> pose_closed_form(std::span<const Eigen::Vector3d> points,
                                     std::span<const Eigen::Vector3d> rays);

}  // namespace tagcal
