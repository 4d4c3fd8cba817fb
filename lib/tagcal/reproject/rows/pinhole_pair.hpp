#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>

#include "tagcal/uncertainty/known_rig.hpp"

// Private to reproject: the pinholes of a rectified pair, as cv::stereoRectify chooses them.
namespace tagcal::internal {

// The scales of a lens on its axis, in pixels per radian along x and y.
Eigen::Vector2d scale_on_axis(const KnownRig::Member& member);

// Half of the relative rotation for each camera, and then the smallest rotation that takes the
// baseline to the nearer of the axes x and y.
struct PairOrientation {
  std::array<Eigen::Quaterniond, 2> rectified_from_camera;
  bool is_vertical = false;
  double translation_m = 0;
};

// Of one focal length.
struct PinholePair {
  double focal_px = 0;
  std::array<Eigen::Vector2d, 2> centre;
};

// alpha and zero_disparity: as in RectifyOptions. Throws Error for a focal length that is far from
// the cameras'.
PinholePair pinholes_of(const std::array<const KnownRig::Member*, 2>& members,
                        const PairOrientation& orientation, bool zero_disparity,
                        std::optional<double> alpha);

// The angles of a direction towards the axis x and about it, from z to y
// (PanoramaKind::transverse).
inline Eigen::Vector2d transverse_angles(const Eigen::Vector3d& direction) {
  return {std::atan2(direction.x(), direction.tail<2>().norm()),
          std::atan2(direction.y(), direction.z())};
}

}  // namespace tagcal::internal
