#include <Eigen/Core>
#include <cmath>

#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/unified_sphere.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
using Eigen::Vector2d;
using Eigen::Vector3d;

double ExtendedUnified::max_angle() const {
  const double w = UnifiedSphere{p_[4]}.w();
  return std::atan2(std::sqrt((1 - w * w) / p_[5]), -w);
}

std::optional<Ray> ExtendedUnified::ray_in_camera(const Vector2d& pixel) const {
  const Vector2d m((pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1]);
  if (!m.allFinite()) return std::nullopt;
  // The unified model of (sqrt(beta) X, sqrt(beta) Y, Z).
  const std::optional<double> z = UnifiedSphere{p_[4]}.depth(p_[5] * m.squaredNorm());
  if (!z) return std::nullopt;
  return Ray{Vector3d::Zero(), Vector3d(m.x(), m.y(), *z).normalized()};
}

ExtendedUnified unified_from_omni(double xi, double fu, double fv, double pu, double pv) {
  if (!(xi >= 0 && std::isfinite(xi)))
    throw Error("lens: xi must be >= 0, got " + short_number(xi));
  return ExtendedUnified({fu / (1 + xi), fv / (1 + xi), pu, pv, xi / (1 + xi), 1});
}

}  // namespace tagcal
