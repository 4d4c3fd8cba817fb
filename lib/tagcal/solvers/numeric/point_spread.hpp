#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {

// The shape of a set of points decides which solver fits it.
enum class PointShape { point, line, plane, space };

// A set of points: its shape, centre, size, and a frame whose xy-plane is the best plane through
// it.
struct PointSpread {
  PointShape shape = PointShape::point;
  double size = 0;       // RMS distance from the centre along the longest axis, metres
  double width = 0;      // RMS along the second axis / size
  double thickness = 0;  // RMS distance from the best plane / size
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d plane_from_target = Eigen::Matrix3d::Identity();  // a rotation

  // Coordinates about the centre, along the axes of the plane; exact for a distant origin too.
  Eigen::Vector3d in_plane(const Eigen::Vector3d& point) const {
    return plane_from_target * ((point - reference) - from_reference);
  }
  Pose plane_from_target_pose() const;
  // False for points on a line or at one place: a width below 1e-6, or below the rounding of the
  // coordinates.
  bool is_wide() const;

  Eigen::Vector3d reference = Eigen::Vector3d::Zero();  // centre = reference + from_reference
  Eigen::Vector3d from_reference = Eigen::Vector3d::Zero();
};

// An extent below 1e-3 of the longest axis counts as zero (line, point). A thickness below 5 % of
// it counts as a plane, for the start of a solver that then uses the true points.
PointSpread spread_of(std::span<const Eigen::Vector3d> points);

}  // namespace tagcal::internal
