#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/geometry/pose.hpp"

// Private to detect.
namespace tagcal::internal {

struct PanelCorner {
  Eigen::Vector2d on_panel;  // in the panel's plane, any unit
  Eigen::Vector2d pixel;
  double sd_px = 1;  // up to a factor that all corners share
};

// A lens estimated from the panel in one picture. Only its projection of that plane is determined:
// a panel that faces the camera fits any focal length.
struct PanelLens {
  Camera camera;
  Pose camera_from_panel;
  double spread = 0;  // robust standard deviation of the residuals, in sds of the corners

  // Lenses at kNearby times the columns of a square root of the lens' covariance.
  static constexpr double kNearby = 0.1;  // numeric: a small step, by which differences are divided
  std::vector<Lens> nearby;

  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& on_panel) const;
};

// Focal lengths in longer sides of the picture: half fields of view from 95 to 13 degrees.
inline constexpr double kPanelFocals[] = {0.3, 0.45, 0.7, 1.2, 2.2};  // numeric: tried values

// A fisheye with equal angles a pixel, with its axis in the middle of the picture.
Camera equidistant(double focal_sides, const ImageSize& size);

// Fits a fisheye lens (Kannala and Brandt 2006), its principal point and the panel's pose to the
// corners of one picture, with a robust cost. Its polynomial approximates any radial lens over the
// angles of a picture. No value for fewer than 24 corners, or if no start converges. `start`, a
// lens from almost the same corners, saves time.
std::optional<PanelLens> lens_of_panel(std::span<const PanelCorner> corners, const ImageSize& size,
                                       const PanelLens* start = nullptr);

}  // namespace tagcal::internal
