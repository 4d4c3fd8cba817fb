#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tagcal/camera/lens.hpp"
#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal::internal {

// Follows the images of convex polygons in the camera frame through a lens, by chords that lie
// within 1e-4 px of the true curves. Outlines are in cells of a raster `scale` times the image's.
class Tracer {
 public:
  // The lens must outlive it.
  Tracer(const Lens& lens, double scale) : lens_(lens), scale_(scale) {}

  // Adds the image of what the lens can see of the polygon.
  void trace(const std::vector<Eigen::Vector3d>& polygon, Outlines& outlines) const;

  // The same for a polygon inside another one for which sees_whole is true.
  void trace_whole(std::span<const Eigen::Vector3d> polygon, Outlines& outlines) const;

  // Returns true if the lens can see the whole polygon.
  bool sees_whole(const std::vector<Eigen::Vector3d>& polygon) const;

 private:
  struct Point {
    Eigen::Vector3d x_in_camera;
    Eigen::Vector2d pixel;
  };

  std::optional<Point> imaged(const Eigen::Vector3d& x_in_camera) const;
  bool follow_edge(const Point& a, const Point& b, std::vector<Eigen::Vector2d>& out) const;
  bool follow(const Point& a, const Point& middle, const Point& b, int depth,
              std::vector<Eigen::Vector2d>& out) const;
  void emit(const Point& point, std::vector<Eigen::Vector2d>& out) const;

  const Lens& lens_;
  double scale_;
};

}  // namespace tagcal::internal
