#include <Eigen/Core>
#include <cmath>

#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/unified_sphere.hpp"

namespace tagcal {
using namespace internal;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The angle phi at the second sphere's centre, which is xi behind that of the first, is smaller
// than the angle there by asin(xi sin(phi)).
double DoubleSphere::max_angle() const {
  const double phi = std::acos(-UnifiedSphere{p_[5]}.w());
  return phi + std::asin(p_[4] * std::sin(phi));
}

std::optional<Ray> DoubleSphere::ray_in_camera(const Vector2d& pixel) const {
  const Vector2d m((pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1]);
  if (!m.allFinite()) return std::nullopt;
  const double square = m.squaredNorm(), xi = p_[4];
  const std::optional<double> z = UnifiedSphere{p_[5]}.depth(square);
  if (!z) return std::nullopt;
  // The point t (x, y, z) - (0, 0, xi) of the first sphere: t > 0 is the larger root.
  const double t = (*z * xi + std::sqrt(*z * *z + (1 - xi * xi) * square)) / (*z * *z + square);
  return Ray{Vector3d::Zero(), Vector3d(t * m.x(), t * m.y(), t * *z - xi).normalized()};
}

}  // namespace tagcal
