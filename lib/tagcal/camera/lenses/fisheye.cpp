#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "tagcal/camera/kernels/lens_kernels.hpp"
#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/polynomial.hpp"

namespace tagcal {
using namespace internal;
using Eigen::Vector2d;
using Eigen::Vector3d;

Fisheye::Fisheye(const Parameters& parameters) : LensOf(parameters) {
  const Polynomial slope = {1, 0, 3 * p_[4], 0, 5 * p_[5], 0, 7 * p_[6], 0, 9 * p_[7]};
  max_angle_ = std::min(std::numbers::pi, smallest_positive_root(slope, std::numbers::pi));
}

std::optional<Ray> Fisheye::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  const Vector2d m((pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1]);
  const double theta_d = m.norm();
  if (theta_d == 0) return Ray{Vector3d::Zero(), Vector3d::UnitZ()};
  if (!(theta_d < FisheyeKernel::distorted(p_.data(), max_angle_))) return std::nullopt;
  const auto angle = [p = p_.data()](double theta) -> std::pair<double, double> {
    return {FisheyeKernel::distorted(p, theta), FisheyeKernel::slope(p, theta)};
  };
  const double theta = solve_increasing(angle, theta_d, 0, max_angle_);
  Vector3d direction;
  direction << std::sin(theta) / theta_d * m, std::cos(theta);
  return Ray{Vector3d::Zero(), direction.normalized()};
}

}  // namespace tagcal
