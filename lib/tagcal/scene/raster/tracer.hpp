#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <span>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal::internal {

// Follows the images of convex polygons in the camera frame through a lens, by chords that lie
// within 1e-4 px of the true curves in the image and around it. Outlines are in cells of a raster
// `scale` times the image's.
class Tracer {
 public:
  // The camera must outlive it.
  Tracer(const Camera& camera, double scale) : camera_(camera), scale_(scale) {}

  // The parts of a polygon that the lens can see.
  std::vector<std::vector<Eigen::Vector3d>> in_domain(
      const std::vector<Eigen::Vector3d>& polygon) const;

  // Adds the image of a polygon inside such a part.
  void trace(std::span<const Eigen::Vector3d> polygon, Outlines& outlines) const;

 private:
  struct Point {
    Eigen::Vector3d x_in_camera;
    Eigen::Vector2d pixel;
  };

  std::optional<Point> imaged(const Eigen::Vector3d& x_in_camera) const;
  bool follow_edge(const Point& a, const Point& b, std::vector<Eigen::Vector2d>& out) const;
  bool follow(const Point& a, const Point& middle, const Point& b, int depth,
              std::vector<Eigen::Vector2d>& out) const;
  bool is_far_beside(std::initializer_list<const Point*> points) const;
  void emit(const Point& point, std::vector<Eigen::Vector2d>& out) const;

  const Camera& camera_;
  double scale_;
};

}  // namespace tagcal::internal
