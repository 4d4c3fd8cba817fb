#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/kernels/lens_kernels.hpp"
#include "tagcal/camera/lens.hpp"
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

using Kernel = PerspectiveKernel<kRational>;  // the others omit terms that are zero

// Start of Newton's method: the radius r < max_radius with r L(r) = distorted_radius to a
// thousandth, tangential terms ignored.
double undistorted_radius(const Perspective::Parameters& p, double max_radius,
                          double distorted_radius) {
  const auto f = [&p](double r) -> std::pair<double, double> {
    const auto d = Kernel::distort(p.data(), r, 0.0);
    return {r * d.radial, d.radial + 2 * d.s * Kernel::radial_slope(p.data(), d)};
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
  const auto distort = [&p](const Vector2d& at) {
    return Kernel::distort(p.data(), at.x(), at.y());
  };
  const auto error_of = [&target](const auto& d) {
    return Vector2d(d.xd - target.x(), d.yd - target.y());
  };
  auto d = distort(x);
  double error = error_of(d).norm();
  const double scale = 1 + target_radius;
  for (int i = 0; i < 100 && error > 0; ++i) {
    const auto [xx, xy, yy] = Kernel::distortion_jacobian(p.data(), d);
    const Vector2d step =
        (Matrix2d() << xx, xy, xy, yy).finished().partialPivLu().solve(error_of(d));
    double share = 1;
    Vector2d next = x - step;
    auto next_d = distort(next);
    while (!(next.norm() < max_radius && error_of(next_d).norm() < error)) {
      share /= 2;
      if (share < 1e-12 || step.norm() * share < 1e-17 * x.norm()) {
        if (error <= 1e-13 * scale) return x;  // limited by rounding
        return std::nullopt;
      }
      next = x - share * step;
      next_d = distort(next);
    }
    x = next;
    d = next_d;
    error = error_of(d).norm();
  }
  if (error <= 1e-13 * scale) return x;
  return std::nullopt;
}

}  // namespace

Perspective::Perspective(const Parameters& parameters)
    : LensOf(parameters), max_radius_(perspective_max_radius(p_)) {}

double Perspective::max_angle() const { return std::atan(max_radius_); }

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
