#pragma once

#include <numbers>

// The constants of reprojection, with meaning, unit and source.
namespace tagcal::internal::policy {

// Area-correct resampling: source pixels per target pixel up to which the kernel stays as it is,
// and above which it is as wide as the target pixel. Bilinear interpolation damps the first
// frequency that aliases (1 / scale cycles per pixel) by sinc^2: to 5 % at 1.25. Between the two
// the width grows linearly, so that a picture has no line where sharpness changes.
inline constexpr double kPlainScale = 1.25;
inline constexpr double kFullScale = 1.5;

// A footprint up to this much longer than wide is taken as round, as wide as it is long: one sample
// of the kernel serves it. A longer one is this much wider than its short axis.
inline constexpr double kRoundRatio = 1.25;

// Distance in pixels of the nodes at which the Jacobian of a map is computed. Between them it is
// interpolated; its largest stretch within a block is then at a corner of the block, because the
// spectral norm is convex.
inline constexpr int kBlock = 32;

// Samples along the long axis of a footprint are at most this far apart, in widths of the kernel
// across it. The sum of tents at that distance is even to 2 %.
inline constexpr double kSampleDistance = 0.75;

// A pinhole is refused if it shows rays beyond this angle from its axis (its pixels then are
// 1 / cos^2 = 33 times as long as those in the middle), and a region of valid pixels reaches to it
// at most.
inline constexpr double kWidestAngle = 80 * std::numbers::pi / 180;

// A cylindrical panorama shows latitudes up to this (1 / cos^2 = 4 times the middle's length).
inline constexpr double kCylinderLatitude = 60 * std::numbers::pi / 180;

// One pinhole of several shows at most this much from top to bottom.
inline constexpr double kFanHeight = 100 * std::numbers::pi / 180;

// Rectification. The optical axis of each camera is at most this far from the direction in which
// both rectified cameras look: beyond it, a part of the picture of a usual lens, 60 degrees wide,
// is behind it.
inline constexpr double kMostRectifiedTurn = 60 * std::numbers::pi / 180;
// The focal length of rectified pinholes is at most this many times that of the cameras, and at
// least the same part of it.
inline constexpr double kMostRectifiedZoom = 10;
// Centres of cameras nearer than this have no direction of a baseline, m.
inline constexpr double kLeastBaseline = 1e-9;
// Rectified pictures are searched for a common view at this many points along rows and columns.
inline constexpr int kViewSamples = 48;

}  // namespace tagcal::internal::policy
