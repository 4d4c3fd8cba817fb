#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/solvers/p4pf.hpp"

// Closed forms for points in a plane, exact without noise, without heap. Rays are directions in the
// camera frame of any length but zero, so views beyond 180 degrees are possible. Points are (X, Y)
// in the plane; its origin is best near the centre of the points.

namespace tagcal {

// Returns H with ray_i ~ H (X_i, Y_i, 1), each a positive multiple: the points lie in front. Four
// points use the two projective bases (Hartley & Zisserman 2004, section 2.3), exactly; more points
// the normalised direct linear transformation (algorithm 4.2) with the centre of the points kept in
// front of the camera. No value if the points do not determine H (three of four on a line), or if
// no H keeps them in front. Throws Error unless there are as many rays as points.
std::optional<Eigen::Matrix3d> homography(std::span<const Eigen::Vector2d> points,
                                          std::span<const Eigen::Vector3d> rays);

// Returns both poses of a plane from its homography to rays (Collins & Bartoli, Infinitesimal
// plane-based pose estimation, IJCV 2014, eqs. 24-31): they agree with H and its derivative at the
// origin of the plane. They are equal if the plane faces the camera. The caller decides which of
// them fits the other points. Empty unless H is finite and regular.
Solutions<Pose, 2> ippe(const Eigen::Matrix3d& camera_from_plane);

// Returns the focal length, as a multiple of the one that the rays were made with, from
// homographies of one camera whose principal point is known: h1 and h2 are images of orthogonal
// directions of equal length (Zhang, PAMI 2000, eqs. 3-4, with one unknown). No value if they do
// not determine it (frontal planes).
std::optional<double> focal_ratio_from_homographies(std::span<const Eigen::Matrix3d> homographies);

// Returns the pose of a plane from its homography to rays of a calibrated camera (Zhang 2000,
// section 3.1), H ~ [r1 r2 t]. This one pose uses all of H.
Pose pose_from_homography(const Eigen::Matrix3d& camera_from_plane);

// Returns pose and focal length of a plane from four points or more, by the two functions above.
// Pixels are relative to the principal point of a pinhole with square pixels.
std::optional<PoseAndFocal> plane_pose_and_focal(
    std::span<const Eigen::Vector2d> points, std::span<const Eigen::Vector2d> pixels_from_centre);

}  // namespace tagcal
