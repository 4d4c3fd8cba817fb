#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/lens_parameters.hpp"
#include "tagcal/camera/lenses/polynomial.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Largest radius of a fold that is searched: beyond it the ray is within 1e-6 rad of a right angle.
constexpr double kLargestRadius = 1e6;

bool is_distorted(const Perspective::Parameters& p) {
  return std::any_of(p.begin() + kK1, p.end(), [](double k) { return k != 0; });
}

// See Perspective in the header. The Jacobian of the distortion is L I + 2 L' x x^T + T(x), all
// symmetric: radially d(rL)/dr, across L, and the tangential terms T, whose radial diagonal and row
// sum are at most sqrt(40) |p| r. So it is positive definite at least as long as
// d(rL)/dr > sqrt(40) |p| r holds from the axis on (L itself is then large enough), before a pole.
double perspective_max_radius(const Perspective::Parameters& p) {
  if (!is_distorted(p)) return std::numeric_limits<double>::infinity();
  const Polynomial numerator = {1, 0, p[kK1], 0, p[kK2], 0, p[kK3]};
  const Polynomial denominator = {1, 0, p[kK4], 0, p[kK5], 0, p[kK6]};
  // d(r N / D) / dr = (N D + r (N' D - N D')) / D^2
  const Polynomial nd = multiply(numerator, denominator);
  Polynomial slope = nd;
  const Polynomial n1d = multiply(derivative(numerator), denominator);
  const Polynomial nd1 = multiply(numerator, derivative(denominator));
  for (std::size_t i = 0; i < n1d.size(); ++i) slope[i + 1] += n1d[i] - nd1[i];
  const double tangential = std::sqrt(40.0) * std::hypot(p[kP1], p[kP2]);
  const Polynomial dd = multiply(denominator, denominator);
  slope.push_back(0);
  for (std::size_t i = 0; i < dd.size(); ++i) slope[i + 1] -= tangential * dd[i];
  while (slope.back() == 0) slope.pop_back();  // the constant is 1
  return std::min(smallest_positive_root(slope, kLargestRadius),
                  smallest_positive_root(denominator, kLargestRadius));
}

// The distortion at (x, y) and the terms of its derivatives.
struct Distorted {
  Vector2d xy;
  double s;            // x^2 + y^2
  double radial;       // L
  double numerator;    // of L
  double denominator;  // of L
};

Distorted distort(const Perspective::Parameters& p, double x, double y) {
  const double s = x * x + y * y;
  const double numerator = 1 + s * (p[kK1] + s * (p[kK2] + s * p[kK3]));
  const double denominator = 1 + s * (p[kK4] + s * (p[kK5] + s * p[kK6]));
  const double radial = numerator / denominator;
  return {{x * radial + 2 * p[kP1] * x * y + p[kP2] * (s + 2 * x * x),
           y * radial + p[kP1] * (s + 2 * y * y) + 2 * p[kP2] * x * y},
          s,
          radial,
          numerator,
          denominator};
}

// d(x', y') / d(x, y)
Matrix2d distortion_jacobian(const Perspective::Parameters& p, const Distorted& d, double x,
                             double y) {
  const double n1 = p[kK1] + d.s * (2 * p[kK2] + d.s * 3 * p[kK3]);
  const double d1 = p[kK4] + d.s * (2 * p[kK5] + d.s * 3 * p[kK6]);
  const double radial_slope = 2 * (n1 - d.radial * d1) / d.denominator;  // 2 dL/ds
  const double off = radial_slope * x * y + 2 * p[kP1] * x + 2 * p[kP2] * y;
  Matrix2d j;
  j << d.radial + radial_slope * x * x + 2 * p[kP1] * y + 6 * p[kP2] * x, off, off,
      d.radial + radial_slope * y * y + 6 * p[kP1] * y + 2 * p[kP2] * x;
  return j;
}

// Start of Newton's method: the radius r < max_radius with r L(r) = distorted_radius to a
// thousandth, tangential terms ignored.
double undistorted_radius(const Perspective::Parameters& p, double max_radius,
                          double distorted_radius) {
  const auto f = [&p](double r) -> std::pair<double, double> {
    const double s = r * r;
    const double n = 1 + s * (p[kK1] + s * (p[kK2] + s * p[kK3]));
    const double d = 1 + s * (p[kK4] + s * (p[kK5] + s * p[kK6]));
    const double n1 = p[kK1] + s * (2 * p[kK2] + s * 3 * p[kK3]);
    const double d1 = p[kK4] + s * (2 * p[kK5] + s * 3 * p[kK6]);
    return {r * n / d, (n + 2 * s * (n1 - n / d * d1)) / d};
  };
  double high = std::min(2 * distorted_radius + 1, 0.999999 * max_radius);
  while (f(high).first < distorted_radius && high < 0.9 * max_radius && high < kLargestRadius)
    high = std::min(2 * high, 0.999999 * max_radius);
  if (f(high).first <= distorted_radius) return high;
  return solve_increasing(f, distorted_radius, 0, high, 1e-3);
}

// The point (x, y) inside max_radius whose distorted position is `target`. The distortion is the
// gradient of a convex function there, so damped Newton steps converge to the only solution, if
// any.
std::optional<Vector2d> undistort(const Perspective::Parameters& p, double max_radius,
                                  const Vector2d& target) {
  if (!is_distorted(p)) return target;
  const double target_radius = target.norm();
  if (target_radius == 0 && p[kP1] == 0 && p[kP2] == 0) return Vector2d::Zero();
  const double start = undistorted_radius(p, max_radius, target_radius);
  Vector2d x = target_radius > 0 ? Vector2d(start / target_radius * target) : Vector2d::Zero();
  Distorted d = distort(p, x.x(), x.y());
  double error = (d.xy - target).norm();
  const double scale = 1 + target_radius;
  for (int i = 0; i < 100 && error > 0; ++i) {
    const Vector2d step =
        distortion_jacobian(p, d, x.x(), x.y()).partialPivLu().solve(d.xy - target);
    double share = 1;
    Vector2d next = x - step;
    Distorted next_d = distort(p, next.x(), next.y());
    while (!(next.norm() < max_radius && (next_d.xy - target).norm() < error)) {
      share /= 2;
      if (share < 1e-12 || step.norm() * share < 1e-17 * x.norm()) {
        if (error <= 1e-13 * scale) return x;  // limited by rounding
        return std::nullopt;
      }
      next = x - share * step;
      next_d = distort(p, next.x(), next.y());
    }
    x = next;
    d = next_d;
    error = (d.xy - target).norm();
  }
  if (error <= 1e-13 * scale) return x;
  return std::nullopt;
}

}  // namespace

Perspective::Perspective(const Parameters& parameters)
    : p_(checked<Perspective>(parameters)), max_radius_(perspective_max_radius(p_)) {}

bool Perspective::in_domain(const Vector3d& x_in_camera) const {
  if (!(x_in_camera.z() > 0)) return false;
  const double x = x_in_camera.x() / x_in_camera.z();
  const double y = x_in_camera.y() / x_in_camera.z();
  return x * x + y * y < max_radius_ * max_radius_;  // false for infinite and NaN as well
}

std::optional<Vector2d> Perspective::project(const Vector3d& x_in_camera) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  const Vector2d distorted =
      distort(p_, x_in_camera.x() / x_in_camera.z(), x_in_camera.y() / x_in_camera.z()).xy;
  return Vector2d(p_[kFx] * distorted.x() + p_[kCx], p_[kFy] * distorted.y() + p_[kCy]);
}

std::optional<Vector2d> Perspective::project(const Vector3d& x_in_camera, PointJacobian* by_point,
                                             ParameterJacobian* by_parameters) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  const double x = x_in_camera.x() / x_in_camera.z();
  const double y = x_in_camera.y() / x_in_camera.z();
  const Distorted d = distort(p_, x, y);
  const Vector2d focal(p_[kFx], p_[kFy]);
  if (by_point) {
    by_point->leftCols<2>() =
        focal.asDiagonal() * distortion_jacobian(p_, d, x, y) / x_in_camera.z();
    by_point->col(2) = -(by_point->col(0) * x + by_point->col(1) * y);
  }
  if (by_parameters) {
    const Vector2d radial = focal.cwiseProduct(Vector2d(x, y)) / d.denominator;  // by N
    const Vector2d rational = -radial * d.radial;                                // by D
    auto& j = *by_parameters;
    j.col(kFx) << d.xy.x(), 0;
    j.col(kFy) << 0, d.xy.y();
    j.col(kCx) << 1, 0;
    j.col(kCy) << 0, 1;
    j.col(kP1) << focal.x() * 2 * x * y, focal.y() * (d.s + 2 * y * y);
    j.col(kP2) << focal.x() * (d.s + 2 * x * x), focal.y() * 2 * x * y;
    j.col(kK1) = d.s * radial;
    j.col(kK2) = d.s * j.col(kK1);
    j.col(kK3) = d.s * j.col(kK2);
    j.col(kK4) = d.s * rational;
    j.col(kK5) = d.s * j.col(kK4);
    j.col(kK6) = d.s * j.col(kK5);
  }
  return Vector2d(focal.x() * d.xy.x() + p_[kCx], focal.y() * d.xy.y() + p_[kCy]);
}

std::optional<Ray> Perspective::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  const std::optional<Vector2d> xy = undistort(
      p_, max_radius_, {(pixel.x() - p_[kCx]) / p_[kFx], (pixel.y() - p_[kCy]) / p_[kFy]});
  if (!xy) return std::nullopt;
  return Ray{Vector3d::Zero(), xy->homogeneous().normalized()};
}

Perspective pinhole(double fx, double fy, double cx, double cy) {
  return Perspective({fx, fy, cx, cy, 0, 0, 0, 0, 0, 0, 0, 0});
}

}  // namespace tagcal
