#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "tagcal/reproject/types.hpp"
#include "tagcal/uncertainty/known_rig.hpp"

// Two cameras of a rig as they would see if their epipolar lines were equal rows.

namespace tagcal {

struct RectifyOptions {
  // Of pinholes: 0: only pixels that the cameras see; 1: all that they see; between: between. None:
  // the focal length is that of the cameras.
  std::optional<double> alpha;
  // Infinitely far points have equal pixels in both pictures.
  bool zero_disparity = true;
  // For lenses wider than a pinhole shows: panoramas, whose rows are angles about the baseline, and
  // whose columns are latitudes towards it. They show the rows that both cameras see.
  bool longlat = false;
};

// Both rectified cameras have one orientation, with x along the baseline; with y, and columns for
// rows, if the second camera is more above or below the first one than beside it.
struct RectifiedPair {
  std::array<std::size_t, 2> cameras = {};  // in the rig
  bool is_vertical = false;
  // Pinholes of one focal length, or panoramas of one resolution; of equal sizes.
  std::array<Target, 2> targets;
  std::array<Pose, 2> camera_from_rectified;  // rotations
  // The second camera's frame is translated by that along x (y): negative if it is right of (below)
  // the first one. Disparities of points before the cameras, first - second, have the other sign.
  double translation_m = 0;
};

// Rotations, focal length and principal points are those of cv::stereoRectify (CALIB_ZERO_DISPARITY
// by default), for all central lenses: its corners and its 9 x 9 points are undistorted exactly,
// not by five iterations; rays beyond the fold of a distortion, or more than 80 degrees from the
// axis of the pinhole, are moved to there. The pictures have the size of the first camera's.
//
// Throws Error for alpha outside [0, 1] or with longlat, a camera that the rig does not have, one
// camera twice, a parallel lens, centres at one place, a camera that looks more than 60 degrees
// away from the rectified direction (one of two that look at each other, or one before the other),
// a focal length that is not positive or ten times off the cameras', and pictures without a common
// point.
RectifiedPair rectify(const KnownRig& rig, std::size_t first, std::size_t second,
                      const RectifyOptions& options = {});

// What the picture k (0 or 1) of a pair is made by (maps.hpp, resampling.hpp).
Reprojection rectification(const KnownRig& rig, const RectifiedPair& pair, std::size_t k);

// P1, P2 and Q of cv::stereoRectify, for pinholes: P takes points of the first rectified camera's
// frame to pixels of picture k; Q takes (u, v, disparity, 1) to homogeneous points of that frame.
// Precondition: the targets are cameras.
using ProjectionMatrix = Eigen::Matrix<double, 3, 4, Eigen::DontAlign>;
using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::DontAlign>;
ProjectionMatrix projection_matrix(const RectifiedPair& pair, std::size_t k);
Matrix4 disparity_to_depth(const RectifiedPair& pair);

// The rectified pixel of a pixel of camera k; no value where that has no ray, or no place in the
// rectified picture's plane.
std::optional<Eigen::Vector2d> rectified_pixel(const KnownRig& rig, const RectifiedPair& pair,
                                               std::size_t k, const Eigen::Vector2d& pixel);

// The row of a point in the first rectified picture less that in the second one (columns, if the
// pair is vertical): 0 without errors.
struct VerticalDisparity {
  double difference_px = 0;
  double sigma_px = 0;         // by the noise of the pixels, and by the next
  double sigma_of_rig_px = 0;  // by the places and lenses of both cameras
};

// Of the pixels at which the two cameras see one point. No value where rectified_pixel has none.
// Throws Error if the rig's covariance does not have its size.
std::optional<VerticalDisparity> vertical_disparity(const KnownRig& rig, const RectifiedPair& pair,
                                                    const std::array<UncertainPixel, 2>& seen);

}  // namespace tagcal
