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
  double sd_px = 1;  // roughly, in proportion to the others'
};

// A lens under which one picture shows a panel. Only what it does to that plane is determined: a
// panel that faces the camera fits any focal length.
struct PanelLens {
  Camera camera;
  Pose camera_from_panel;
  double spread = 0;  // robust standard deviation of the corners about it, in theirs

  // Lenses kNearby standard deviations away, in independent directions that add up to all of the
  // lens' covariance.
  static constexpr double kNearby = 0.1;
  std::vector<Lens> nearby;

  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& on_panel) const;
};

// Fits a fisheye lens (Kannala and Brandt 2006), its principal point and the panel's pose to the
// corners of one picture; corners that are wrong weigh little. Its polynomial is close to any
// radial lens over the angles that a picture shows. No value for fewer than 24 corners, or where no
// start converges. `start`, a lens from almost the same corners, saves time.
std::optional<PanelLens> lens_of_panel(std::span<const PanelCorner> corners, const ImageSize& size,
                                       const PanelLens* start = nullptr);

}  // namespace tagcal::internal
