#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/lens_parameters.hpp"
#include "tagcal/camera/lenses/polynomial.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// theta_d and its derivative by theta.
std::pair<double, double> fisheye_angle(const Fisheye::Parameters& p, double theta) {
  const double s = theta * theta;
  return {theta * (1 + s * (p[4] + s * (p[5] + s * (p[6] + s * p[7])))),
          1 + s * (3 * p[4] + s * (5 * p[5] + s * (7 * p[6] + s * 9 * p[7])))};
}

}  // namespace

Fisheye::Fisheye(const Parameters& parameters) : p_(checked<Fisheye>(parameters)) {
  const Polynomial slope = {1, 0, 3 * p_[4], 0, 5 * p_[5], 0, 7 * p_[6], 0, 9 * p_[7]};
  max_angle_ = std::min(std::numbers::pi, smallest_positive_root(slope, std::numbers::pi));
}

bool Fisheye::in_domain(const Vector3d& x_in_camera) const {
  if (!x_in_camera.allFinite() || x_in_camera.isZero(0)) return false;
  return std::atan2(std::hypot(x_in_camera.x(), x_in_camera.y()), x_in_camera.z()) < max_angle_;
}

std::optional<Vector2d> Fisheye::project(const Vector3d& x_in_camera) const {
  return project(x_in_camera, nullptr, nullptr);
}

std::optional<Vector2d> Fisheye::project(const Vector3d& x_in_camera, PointJacobian* by_point,
                                         ParameterJacobian* by_parameters) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  const Vector2d xy = x_in_camera.head<2>();
  const double z = x_in_camera.z();
  const double radius = std::hypot(xy.x(), xy.y());
  const double theta = std::atan2(radius, z);
  const auto [theta_d, slope] = fisheye_angle(p_, theta);
  const double scale =
      radius > 0 ? theta_d / radius : 1 / z;  // theta_d / radius, its limit on the axis
  const Vector2d focal(p_[0], p_[1]);
  if (by_point) {
    const double square = radius * radius + z * z;
    // d(scale)/d(radius) / radius. Its cancellation near the axis does not matter: it is multiplied
    // by radius^2 below.
    const double by_radius = radius > 0 ? (slope * z / square - scale) / radius / radius : 0.0;
    by_point->leftCols<2>() =
        focal.asDiagonal() * (scale * Matrix2d::Identity() + xy * (by_radius * xy).transpose());
    by_point->col(2) = -slope / square * focal.cwiseProduct(xy);
  }
  if (by_parameters) {
    const Vector2d direction = radius > 0 ? Vector2d(xy / radius) : Vector2d::Zero();
    by_parameters->leftCols<4>() << scale * xy.x(), 0, 1, 0, 0, scale * xy.y(), 0, 1;
    double power = theta;
    for (int i = 4; i < kNumParameters; ++i) {
      power *= theta * theta;
      by_parameters->col(i) = power * focal.cwiseProduct(direction);
    }
  }
  return Vector2d(focal.x() * scale * xy.x() + p_[2], focal.y() * scale * xy.y() + p_[3]);
}

std::optional<Ray> Fisheye::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  const Vector2d m((pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1]);
  const double theta_d = m.norm();
  if (theta_d == 0) return Ray{Vector3d::Zero(), Vector3d::UnitZ()};
  if (!(theta_d < fisheye_angle(p_, max_angle_).first)) return std::nullopt;
  const double theta =
      solve_increasing([this](double t) { return fisheye_angle(p_, t); }, theta_d, 0, max_angle_);
  Vector3d direction;
  direction << std::sin(theta) / theta_d * m, std::cos(theta);
  return Ray{Vector3d::Zero(), direction.normalized()};
}

}  // namespace tagcal
