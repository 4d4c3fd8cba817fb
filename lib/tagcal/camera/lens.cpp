#include "tagcal/camera/lens.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tagcal/camera/polynomial.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A fold further out than this is closer than 1e-6 rad to a right angle: none is looked for.
constexpr double kLargestRadius = 1e6;

template <typename L>
const typename L::Parameters& checked(const typename L::Parameters& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string name(L::kParameterNames[i]);
    if (!std::isfinite(parameters[i])) throw Error("lens: " + name + " is not finite");
    if (i < 2 && !(parameters[i] > 0))
      throw Error("lens: " + name + " must be > 0, got " + std::to_string(parameters[i]));
  }
  return parameters;
}

// Indices into Perspective::Parameters.
enum PerspectiveIndex { kFx, kFy, kCx, kCy, kK1, kK2, kP1, kP2, kK3, kK4, kK5, kK6 };

// See Perspective in the header. The Jacobian of the distortion is L I + 2 L' x x^T + T(x), all
// symmetric: radially d(rL)/dr, across L, and the tangential terms T, whose radial diagonal and row
// sum are at most sqrt(40) |p| r. So it is positive definite at least as long as
// d(rL)/dr > sqrt(40) |p| r holds from the axis on (L itself is then large enough), before a pole.
double perspective_max_radius(const Perspective::Parameters& p) {
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

// The distortion at (x, y) and what its derivatives need.
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

// The radius r < max_radius with r L(r) = distorted_radius, for a lens without tangential terms;
// else a start for Newton's method.
double undistorted_radius(const Perspective::Parameters& p, double max_radius,
                          double distorted_radius) {
  const auto f = [&p](double r) -> std::pair<double, double> {
    const Distorted d =
        distort({1, 1, 0, 0, p[kK1], p[kK2], 0, 0, p[kK3], p[kK4], p[kK5], p[kK6]}, r, 0);
    const double n1 = p[kK1] + d.s * (2 * p[kK2] + d.s * 3 * p[kK3]);
    const double d1 = p[kK4] + d.s * (2 * p[kK5] + d.s * 3 * p[kK6]);
    return {r * d.radial, d.radial + 2 * d.s * (n1 - d.radial * d1) / d.denominator};
  };
  double high = std::min(2 * distorted_radius + 1, 0.999999 * max_radius);
  while (f(high).first < distorted_radius && high < 0.9 * max_radius && high < kLargestRadius)
    high = std::min(2 * high, 0.999999 * max_radius);
  return f(high).first <= distorted_radius ? high : solve_increasing(f, distorted_radius, 0, high);
}

// (x, y) inside max_radius whose distortion is `target`. The distortion is the gradient of a convex
// function there, so damped Newton steps end at the one solution if there is any.
std::optional<Vector2d> undistort(const Perspective::Parameters& p, double max_radius,
                                  const Vector2d& target) {
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
        if (error <= 1e-13 * scale) return x;  // as far as rounding lets it
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

// theta_d and its derivative by theta.
std::pair<double, double> fisheye_angle(const Fisheye::Parameters& p, double theta) {
  const double s = theta * theta;
  return {theta * (1 + s * (p[4] + s * (p[5] + s * (p[6] + s * p[7])))),
          1 + s * (3 * p[4] + s * (5 * p[5] + s * (7 * p[6] + s * 9 * p[7])))};
}

template <typename L>
std::size_t project_all(const L& lens, const Pose& camera_from_source,
                        std::span<const Vector3d> x_in_source, std::span<Vector2d> pixels,
                        std::span<std::uint8_t> valid) {
  const Eigen::Matrix3d rotation = camera_from_source.rotation_matrix();
  const Vector3d translation = camera_from_source.translation();
  std::size_t count = 0;
  for (std::size_t i = 0; i < x_in_source.size(); ++i) {
    const std::optional<Vector2d> pixel = lens.project(rotation * x_in_source[i] + translation);
    valid[i] = pixel.has_value();
    pixels[i] = pixel.value_or(Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
    count += pixel.has_value();
  }
  return count;
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
    // d(scale)/d(radius) / radius; what cancels in it near the axis is multiplied by radius^2
    // below.
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

Parallel::Parallel(const Parameters& parameters) : p_(checked<Parallel>(parameters)) {}

bool Parallel::in_domain(const Vector3d& x_in_camera) const { return x_in_camera.allFinite(); }

std::optional<Vector2d> Parallel::project(const Vector3d& x_in_camera) const {
  return project(x_in_camera, nullptr, nullptr);
}

std::optional<Vector2d> Parallel::project(const Vector3d& x_in_camera, PointJacobian* by_point,
                                          ParameterJacobian* by_parameters) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  if (by_point) *by_point << p_[0], 0, 0, 0, p_[1], 0;
  if (by_parameters) *by_parameters << x_in_camera.x(), 0, 1, 0, 0, x_in_camera.y(), 0, 1;
  return Vector2d(p_[0] * x_in_camera.x() + p_[2], p_[1] * x_in_camera.y() + p_[3]);
}

std::optional<Ray> Parallel::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  return Ray{{(pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1], 0}, Vector3d::UnitZ()};
}

Perspective pinhole(double fx, double fy, double cx, double cy) {
  return Perspective({fx, fy, cx, cy, 0, 0, 0, 0, 0, 0, 0, 0});
}

std::span<const double> parameters(const Lens& lens) {
  return std::visit([](const auto& l) { return std::span<const double>(l.parameters()); }, lens);
}

std::span<const std::string_view> parameter_names(const Lens& lens) {
  return std::visit(
      [](const auto& l) { return std::span<const std::string_view>(l.kParameterNames); }, lens);
}

bool in_domain(const Lens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.in_domain(x_in_camera); }, lens);
}

std::optional<Vector2d> project(const Lens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.project(x_in_camera); }, lens);
}

std::optional<Ray> ray_in_camera(const Lens& lens, const Vector2d& pixel) {
  return std::visit([&](const auto& l) { return l.ray_in_camera(pixel); }, lens);
}

std::size_t project(const Lens& lens, const Pose& camera_from_source,
                    std::span<const Vector3d> x_in_source, std::span<Vector2d> pixels,
                    std::span<std::uint8_t> valid) {
  return std::visit(
      [&](const auto& l) { return project_all(l, camera_from_source, x_in_source, pixels, valid); },
      lens);
}

}  // namespace tagcal
